//! The Ethernet address of a board that has none of its own.
//!
//! ```text
//! 02 │ second to fourth byte of the fleet 3 │ number of the module 2, big endian
//! ```
//!
//! The first byte says: of one station, given out locally (IEEE 802, section 8.4). Modules of one fleet have different numbers,
//! and so different addresses.
//!
//! Assumptions and limits: two modules with one number in two fleets that share a network, and 24 bits of their fleets,
//! disturb each other: one pair of fleets in 16 million.

use protocol::{FleetId, ModuleId};

/// The address of a module.
#[must_use]
pub const fn of(fleet: FleetId, module: ModuleId) -> [u8; 6] {
    let FleetId([_, second, third, fourth]) = fleet;
    let [high, low] = module.0.to_be_bytes();
    [0x02, second, third, fourth, high, low]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_local_of_one_station_and_its_own() {
        let address = of(FleetId([1, 2, 3, 4]), ModuleId(1024));
        assert_eq!(address, [2, 2, 3, 4, 4, 0]);
        assert_eq!(address[0] & 0b11, 0b10);
        assert_ne!(address, of(FleetId([1, 2, 3, 4]), ModuleId(4)));
    }
}
