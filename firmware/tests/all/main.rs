//! Input that no host sends, and the documents made from the failsafe's table.

mod failsafe_picture;
mod fuzzing;
