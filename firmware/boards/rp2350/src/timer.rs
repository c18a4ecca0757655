//! The settings of a PWM slice for a rate of pulses.

use embassy_rp::clocks;
use embassy_rp::pwm::Config;

use crate::frame::Frame;

/// For `rate_hz` pulses a second, none of them before a duty is set; nothing if the timer cannot be so slow or so fast.
#[must_use]
pub fn settings(rate_hz: f32) -> Option<Config> {
    let Frame { divider, top } = Frame::new(clocks::clk_sys_freq(), rate_hz)?;
    let mut settings = Config::default();
    settings.divider = divider.into();
    settings.top = top;
    Some(settings)
}
