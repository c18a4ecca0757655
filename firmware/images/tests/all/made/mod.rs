//! ELF programs made byte by byte, by code that shares nothing with what reads them.

/// A part of a program.
pub struct Part<'a> {
    pub name: &'a str,
    /// Where it runs.
    pub address: u32,
    /// Where it is loaded from; nothing for zeroes.
    pub load: Option<u32>,
    pub bytes: &'a [u8],
}

/// `PT_LOAD` and 32-bit sections, as the linker of a Cortex-M program makes them, and functions of these names in the first part.
pub fn program(parts: &[Part<'_>], functions: &[&str]) -> Vec<u8> {
    const HEAD: usize = 52;
    const SEGMENT: usize = 32;
    const SYMBOL: usize = 16;
    let words = |list: &[u32]| list.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let halves = |list: &[u16]| list.iter().flat_map(|half| half.to_le_bytes()).collect::<Vec<u8>>();

    let mut names = vec![0];
    let mut named = |name: &str| {
        let at = names.len() as u32;
        names.extend_from_slice(name.as_bytes());
        names.push(0);
        at
    };
    let (mut segments, mut sections, mut contents) = (Vec::new(), vec![0; 40], Vec::new());
    let data = HEAD + SEGMENT * parts.len();
    for part in parts {
        let (offset, size) = ((data + contents.len()) as u32, part.bytes.len() as u32);
        let (kind, in_file) = if part.load.is_some() { (1, size) } else { (8, 0) };
        let load = part.load.unwrap_or(part.address);
        segments.extend(words(&[1, offset, part.address, load, in_file, size, 7, 4]));
        sections.extend(words(&[named(part.name), kind, 3, part.address, offset, size, 0, 0, 4, 0]));
        if part.load.is_some() {
            contents.extend_from_slice(part.bytes);
        }
    }
    // Something that takes no memory on the board.
    let comment = (data + contents.len()) as u32;
    contents.extend_from_slice(b"a compiler");
    sections.extend(words(&[named(".comment"), 1, 0, 0, comment, 10, 0, 0, 1, 0]));

    let (mut symbols, count) = (vec![0; SYMBOL], parts.len() as u32);
    for name in functions {
        symbols.extend(words(&[named(name), parts[0].address, 2]));
        // A global function of section 1.
        symbols.extend([0x12, 0, 1, 0]);
    }
    let at = (data + contents.len()) as u32;
    sections.extend(words(&[
        named(".symtab"),
        2,
        0,
        0,
        at,
        symbols.len() as u32,
        count + 3,
        1,
        4,
        SYMBOL as u32,
    ]));
    contents.extend(symbols);
    let own = named(".strtab");
    let at = (data + contents.len()) as u32;
    sections.extend(words(&[own, 3, 0, 0, at, names.len() as u32, 0, 0, 1, 0]));
    contents.extend(names);

    let table = (data + contents.len()) as u32;
    let mut file = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0".to_vec();
    file.extend(halves(&[2, 40]));
    file.extend(words(&[1, parts[0].address | 1, HEAD as u32, table, 0x0500_0400]));
    file.extend(halves(&[HEAD as u16, SEGMENT as u16, count as u16, 40, count as u16 + 4, count as u16 + 3]));
    [file, segments, contents, sections].concat()
}

/// A program like those of boards: a vector table, a block for the boot ROM, code, constants, data that is copied, and memory that is not loaded.
pub fn usual(functions: &[&str]) -> Vec<u8> {
    let flash = |name, address, bytes| Part { name, address, load: Some(address), bytes };
    let parts = [
        flash(".vector_table", 0x1000_0000, &[0x11; 72][..]),
        flash(".start_block", 0x1000_0048, &[0x22; 20]),
        flash(".text", 0x1000_005c, &[0x33; 700]),
        flash(".rodata", 0x1000_0400, &[0x44; 100]),
        Part { name: ".data", address: 0x2000_0000, load: Some(0x1000_0464), bytes: &[0x55; 40] },
        Part { name: ".bss", address: 0x2000_0028, load: None, bytes: &[0; 3000] },
        Part { name: ".uninit", address: 0x2000_0be0, load: None, bytes: &[0; 1024] },
        flash(".extra", 0x1000_048c, &[0x66; 8]),
    ];
    program(&parts, functions)
}
