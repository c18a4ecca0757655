//! Buffers of datagrams that have arrived, to be filled again.

/// No more buffers than this are kept.
const KEPT_MAX: usize = 64;

/// See the module's documentation.
#[derive(Debug, Default)]
pub(crate) struct Spare(Vec<Vec<u8>>);

impl Spare {
    /// A copy of `datagram`, in a buffer that was used before if there is one.
    pub(crate) fn copied(&mut self, datagram: &[u8]) -> Vec<u8> {
        let mut bytes = self.0.pop().unwrap_or_default();
        bytes.clear();
        bytes.extend_from_slice(datagram);
        bytes
    }

    /// Takes back the buffer of a datagram that has arrived.
    pub(crate) fn take_back(&mut self, datagram: Vec<u8>) {
        if self.0.len() < KEPT_MAX {
            self.0.push(datagram);
        }
    }
}
