//! Random bytes from the operating system, for keys and nonces: what must not be guessable. Nothing here has a seed, and
//! nothing that is to be repeated may be drawn here.

use protocol::Nonce;
use thiserror::Error;

/// The operating system gives none.
#[derive(Clone, Copy, Debug, Error)]
#[error("the operating system gives no random bytes: {0}")]
pub struct EntropyError(#[from] getrandom::Error);

/// Fills `bytes`.
///
/// # Errors
/// [`EntropyError`]; `bytes` are then of no use.
pub fn fill(bytes: &mut [u8]) -> Result<(), EntropyError> {
    Ok(getrandom::fill(bytes)?)
}

/// A nonce for a boot or a session.
///
/// # Errors
/// [`EntropyError`].
pub fn nonce() -> Result<Nonce, EntropyError> {
    let mut nonce = Nonce::default();
    fill(&mut nonce.0)?;
    Ok(nonce)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_nonce_comes_twice() {
        let nonces: std::collections::HashSet<_> = (0..1000).map(|_| nonce().unwrap()).collect();
        assert_eq!(nonces.len(), 1000);
        assert!(!nonces.contains(&Nonce::default()));
    }
}
