//! UF2 files, sizes and panics of programs made for the purpose.

mod elf;
mod made;
mod program;
mod uf2;
