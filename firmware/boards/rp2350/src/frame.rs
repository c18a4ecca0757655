//! PWM output that sends one pulse a frame, as speed controllers want it.
//!
//! N = ⌈f_c/(f·65 534)⌉,   T = round(f_c/(f·N)),   pulse of duty d: d·N/f_c = d/(f·T)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | f_c | the timer's clock | Hz |
//! | f | frames a second | Hz |
//! | N | divider: a whole number, so that no step is longer than another | |
//! | T | top: the timer counts 0..=T | |
//!
//! T is the frame's length to the caller that sets a duty (it is the greatest duty of `SetDutyCycle`), so the pulse is right; as the timer
//! counts to T + 1, the frame is longer by one step. At 150 MHz a step is 0.04 µs at 400 Hz and 0.31 µs at 50 Hz.
//!
//! Source: RP2350 datasheet, section 12.5.2: the period is (T + 1)·N, and a new duty begins with a frame. N may be up to 256.

/// PWM output that sends one pulse a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// N.
    pub divider: u8,
    /// T.
    pub top: u16,
}

/// Greatest T: with 65 535 a duty of one more, always high, could not be written.
const TOP_MAX: f32 = 65_534.0;

impl Frame {
    /// For `rate_hz` frames a second; nothing if the timer cannot be so slow or so fast.
    #[must_use]
    pub fn new(clock_hz: u32, rate_hz: f32) -> Option<Self> {
        let counts = clock_hz as f32 / rate_hz;
        // From below 1 on, NaN included, there is no duty but none and all.
        if !(counts >= 2.0 && counts <= TOP_MAX * f32::from(u8::MAX)) {
            return None;
        }
        let divider = (1..=u8::MAX).find(|&divider| counts <= TOP_MAX * f32::from(divider))?;
        // Rounded; positive and at most `TOP_MAX`.
        let top = (counts / f32::from(divider) + 0.5) as u16;
        Some(Self { divider, top })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOCK_HZ: u32 = 150_000_000;

    #[test]
    fn a_pulse_is_as_long_as_it_should_be() {
        for rate_hz in [50.0_f32, 60.0, 61.7, 100.0, 333.0, 400.0] {
            let Frame { divider, top } = Frame::new(CLOCK_HZ, rate_hz).unwrap();
            let step_us = f64::from(divider) * 1e6 / f64::from(CLOCK_HZ);
            assert!(step_us < 0.32, "{rate_hz} Hz: a step of {step_us} µs");
            // As the bank works it out from the greatest duty and the rate.
            let duty = (1_500.0 * f64::from(rate_hz) * f64::from(top) / 1e6).round();
            assert!((duty * step_us - 1_500.0).abs() < 0.2, "{rate_hz} Hz: {} µs", duty * step_us);
            let frame_us = (f64::from(top) + 1.0) * step_us;
            assert!(
                (frame_us - 1e6 / f64::from(rate_hz)).abs() < 2.0 * step_us,
                "{rate_hz} Hz: {frame_us} µs"
            );
        }
    }

    #[test]
    fn uses_the_timer_well() {
        assert_eq!(Frame::new(CLOCK_HZ, 400.0), Some(Frame { divider: 6, top: 62_500 }));
        assert_eq!(Frame::new(CLOCK_HZ, 50.0), Some(Frame { divider: 46, top: 65_217 }));
        assert_eq!(Frame::new(CLOCK_HZ, 20_000.0), Some(Frame { divider: 1, top: 7_500 }));
    }

    #[test]
    fn takes_anything() {
        for rate_hz in [0.0, -400.0, f32::NAN, f32::INFINITY, 1e-3, 1e9] {
            assert_eq!(Frame::new(CLOCK_HZ, rate_hz), None, "{rate_hz} Hz");
        }
        let slowest = Frame::new(CLOCK_HZ, 150e6 / (255.0 * 65_534.0)).unwrap();
        assert_eq!(slowest, Frame { divider: 255, top: 65_534 });
    }
}
