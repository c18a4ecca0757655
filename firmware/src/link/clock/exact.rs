//! Integer conversions of the clock, none of which can overflow.

/// The longest time a drift is followed over: 2⁴⁰ µs, twelve days.
const FAR_US: i64 = 1 << 40;

/// From `earlier` to `later`, µs; at most ±2⁴⁰.
pub(super) fn along(earlier: u64, later: u64) -> i64 {
    let beyond = if later > earlier { FAR_US } else { -FAR_US };
    later.checked_signed_diff(earlier).unwrap_or(beyond).clamp(-FAR_US, FAR_US)
}

/// 10⁻⁹ as a multiple of 2⁻³², rounded.
pub(super) const fn ppb_q32(ppb: i32) -> i64 {
    // 2³² / 10⁹ = 4.294967296 = 4 611 686 018 / 2³⁰
    (ppb as i64).saturating_mul(4_611_686_018) >> 30
}

/// What `ppb` of drift makes of `span_us` (at most ±2⁴⁰), µs, rounded down. For |ppb| < 10⁶.
pub(super) fn drifted_us(span_us: i64, ppb: i32) -> i64 {
    span_us.saturating_mul(ppb_q32(ppb)) >> 32
}

/// Seconds, for the estimate: 134 s to within 8 µs.
#[cfg_attr(not(test), expect(clippy::cast_precision_loss, reason = "seven digits are plenty"))]
pub(super) const fn seconds(us: i64) -> f32 {
    us as f32 * 1e-6
}

/// Microseconds, for the estimate: 1 s to within 0.1 µs.
#[cfg_attr(not(test), expect(clippy::cast_precision_loss, reason = "seven digits are plenty"))]
pub(super) const fn micros(us: i64) -> f32 {
    us as f32
}

/// A count, for the estimate.
#[cfg_attr(not(test), expect(clippy::cast_precision_loss, reason = "seven digits are plenty"))]
pub(super) const fn number(count: u32) -> f32 {
    count as f32
}

/// The nearest whole number towards zero; 0 if it is none.
#[cfg_attr(not(test), expect(clippy::cast_possible_truncation, reason = "saturates"))]
pub(super) const fn whole(value: f32) -> i64 {
    value as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drifts_as_much_as_said() {
        for (span_us, ppb, expected_us) in [
            (1_000_000_000, 1, 1),
            (1_000_000, 300_000, 300),
            (-1_000_000, 300_000, -300),
            (60_000_000, -50_000, -3_000),
        ] {
            let found_us = drifted_us(span_us, ppb);
            assert!((found_us - expected_us).abs() <= 1, "{found_us} for {span_us} µs, {ppb} ppb");
        }
        assert_eq!(
            (along(3, 5), along(5, 3), along(0, u64::MAX), along(u64::MAX, 0)),
            (2, -2, FAR_US, -FAR_US)
        );
    }
}
