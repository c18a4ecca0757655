//! The log of a run: an MCAP file of ROS 2 messages.
//!
//! | file | what |
//! |---|---|
//! | [`cdr`] | how a value lies in a message |
//! | [`message`] | name, schema and CDR of a message, from one definition |
//! | [`ros`], [`flotilla`] | the messages: ROS's, and Flotilla's own |
//! | `mcap` | records of the file |
//! | [`writer`] | writes as it happens |
//! | [`reader`] | reads up to the end, or to where the file is cut |
//! | [`schema`], [`value`] | a schema read back; any message by its schema |
//! | [`table`], [`units`] | tables of them |

pub mod cdr;
pub mod flotilla;
mod mcap;
pub mod message;
pub mod reader;
pub mod ros;
pub mod schema;
pub mod table;
pub mod units;
pub mod value;
pub mod writer;

#[cfg(test)]
mod tests;
