//! Readers of other makers; one program, so that it is linked once.

mod environment;
mod logs;
mod stream;
