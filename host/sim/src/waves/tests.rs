//! Waves against the formulas of the literature, written down a second time.

use std::f64::consts::PI;

use super::*;

#[test]
fn a_regular_wave_is_that_of_linear_theory() {
    let regular = WaveParameters { height_m: 0.02, period_s: 1.0, direction_rad: 0.0 };
    let waves = Waves::new(&regular, &JonswapParameters::default(), 0);
    // H = 2 cm, T = 1 s: u = πH/T = 0.0628 m/s, 2π/T times that as an acceleration, λ = g·T²/2π = 1.561 m.
    let ([u, v], [a, _]) = waves.at(0.0, [0.0, 0.0]);
    assert!((u - PI * 0.02).abs() < 1e-12 && v == 0.0 && a == 0.0, "{u} {v} {a}");
    for (t_s, x_m) in [(0.25, 0.0), (0.1, 0.3), (3.7, -2.0)] {
        let length_m = 9.81 / (2.0 * PI);
        let phase = 2.0 * PI * (x_m / length_m - t_s);
        let ([u, _], [a, _]) = waves.at(t_s, [x_m, 5.0]);
        assert!((u - PI * 0.02 * phase.cos()).abs() < 1e-12, "{u}");
        assert!((a - 2.0 * PI * PI * 0.02 * phase.sin()).abs() < 1e-12, "{a}");
        // The acceleration is the velocity's rate at a place.
        let rate = (waves.at(t_s + 1e-6, [x_m, 5.0]).0[0] - waves.at(t_s - 1e-6, [x_m, 5.0]).0[0]) / 2e-6;
        assert!((rate - a).abs() < 1e-6, "{rate} {a}");
    }
}

/// (w2) as it stands in the literature, with α from H_s by quadrature: m²·s.
fn jonswap(height_m: f64, period_s: f64, peakedness: f64) -> impl Fn(f64) -> f64 {
    let shape = move |f: f64| {
        let (g, peak) = (9.81_f64, 1.0 / period_s);
        let width = if f <= peak { 0.07 } else { 0.09 };
        let bump = f64::exp(-(f - peak).powi(2) / (2.0 * width * width * peak * peak));
        g * g / (2.0 * PI).powi(4) * f.powi(-5) * f64::exp(-1.25 * (peak / f).powi(4)) * peakedness.powf(bump)
    };
    let step = 1e-4 / period_s;
    let moment: f64 = (1..200_000).map(|k| shape(f64::from(k) * step) * step).sum();
    move |f| shape(f) * (height_m / 4.0).powi(2) / moment
}

/// Velocities of a long record at one place, taken apart into frequencies, against (2πf)²·S(f).
#[test]
fn the_spectrum_of_a_sea_is_that_of_jonswap() {
    let (height_m, period_s, peakedness) = (0.03, 1.2, 3.3);
    let sea = JonswapParameters { height_m, period_s, peakedness, direction_rad: 0.7 };
    let spectrum = jonswap(height_m, period_s, peakedness);
    let seeds = 0..12_u64;
    let runs = seeds.clone().count() as f64;
    // 600 s at 10 Hz: bins of 1/600 Hz, grouped by 0.1 peak frequencies.
    let (length_s, rate_hz) = (600.0, 10.0);
    let count = (length_s * rate_hz) as usize;
    let mut seen = [0.0; 30];
    for seed in seeds.clone() {
        let waves = Waves::new(&WaveParameters::default(), &sea, seed);
        let record: Vec<f64> = (0..count)
            .map(|k| {
                let ([u, v], _) = waves.at(k as f64 / rate_hz, [0.4, -0.3]);
                u * 0.7_f64.cos() + v * 0.7_f64.sin()
            })
            .collect();
        for bin in 1..(30.0 * 0.1 / period_s * length_s) as usize {
            let f = bin as f64 / length_s;
            let turn = |k: usize| (2.0 * PI * f * k as f64 / rate_hz).sin_cos();
            let (s, c) = record.iter().enumerate().fold((0.0, 0.0), |(s, c), (k, u)| {
                let (sin, cos) = turn(k);
                (s + u * sin, c + u * cos)
            });
            let band = (f * period_s / 0.1) as usize;
            seen[band] += 2.0 * (s * s + c * c) / (count as f64).powi(2) / runs;
        }
    }
    let (mut whole, mut expected_whole) = (0.0, 0.0);
    for (band, seen) in seen.iter().enumerate().skip(7).take(18) {
        let steps = 200;
        let width = 0.1 / period_s;
        let expected: f64 = (0..steps)
            .map(|k| {
                let f = (band as f64 + (f64::from(k) + 0.5) / f64::from(steps)) * width;
                (2.0 * PI * f).powi(2) * spectrum(f) * width / f64::from(steps)
            })
            .sum();
        // Some two waves fall into a band, each at a frequency of its own in every run.
        assert!((seen / expected - 1.0).abs() < 0.25, "seeds {seeds:?}, band {band}: {seen} for {expected}");
        (whole, expected_whole) = (whole + seen, expected_whole + expected);
    }
    assert!((whole / expected_whole - 1.0).abs() < 0.03, "seeds {seeds:?}: {whole} for {expected_whole}");
}

#[test]
fn a_seed_draws_its_own_sea() {
    let sea = JonswapParameters { height_m: 0.02, ..JonswapParameters::default() };
    let at = |seed| Waves::new(&WaveParameters::default(), &sea, seed).at(3.0, [0.1, 0.2]);
    assert_eq!(at(5), at(5));
    assert_ne!(at(5), at(6));
}

#[test]
fn a_wave_that_would_break_is_refused() {
    let wave = WaveParameters { height_m: 0.25, period_s: 1.0, direction_rad: 0.0 };
    let error = wave.validate().expect_err("0.142·1.561 m = 0.222 m");
    assert_eq!((error.key, error.unit), ("height_m", "m"));
    let flat = JonswapParameters { peakedness: 0.5, ..JonswapParameters::default() };
    assert_eq!(flat.validate().expect_err("below 1").key, "peakedness");
}
