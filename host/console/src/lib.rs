//! The console: a page that shows a run or a log while it goes on and takes orders for it, and a stream of the log's topics for Foxglove's
//! protocol, by one small server.
//!
//! ```text
//! closed loop ─ runlog::writer ─ tap ──┐                          ┌─ page: snapshots, 20 a second
//!                                      ├─→ server ─→ view, stream ┤
//! log file ─────── player ─────────────┘      │                   └─ Foxglove, Lichtblick, PlotJuggler
//! closed loop ←──── desk, deadman ←── asks ───┘
//! ```
//!
//! One encoder feeds everything: what the log writes is what the view is made of, live and from a file. The server has one thread. The
//! closed loop hands it copies through a queue of fixed length and never waits for it: what finds no room is counted. No more is kept for
//! a client than [`client`] says.
//!
//! | file | what |
//! |---|---|
//! | [`tap`] | from the loop to the server |
//! | [`desk`], [`deadman`] | from the server to the loop: what persons ask for, in order |
//! | [`command`] | what the page asks for |
//! | [`access`], [`http`] | who may connect; the request that begins a connection |
//! | [`client`], [`server`] | one connection; all of them |
//! | [`view`] | what a page shows, made of the log's messages |
//! | [`stream`] | Foxglove's protocol |
//! | [`player`] | a log file, at its own pace |
//! | [`page`] | the files that are served |
//!
//! What is said on the page's socket: `host/console/docs/protocol.md`.

pub mod access;
pub mod client;
pub mod command;
pub mod deadman;
pub mod desk;
pub mod http;
pub mod page;
pub mod player;
pub mod server;
pub mod stream;
pub mod tap;
pub mod view;
