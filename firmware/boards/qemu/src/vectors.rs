//! The board's interrupts in the table of vectors: 32 of them (Arm DAI 0386, table 3-6), all to one handler.

unsafe extern "C" {
    fn DefaultHandler();
}

/// Where each interrupt leads.
// SAFETY: the run time's linker script takes this name and this section for the vectors of the interrupts.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); 32] = [DefaultHandler; 32];
