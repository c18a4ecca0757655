//! The paper's table of DoC (§II-A): D(φ₀ᵢ, Aᵢ, φ₀ⱼ, Aⱼ) for centerlines and amplitudes 0.1 rad apart.
//!
//! Negating both amplitudes runs the same segment backwards, which has the same DoC: only |Aᵢ|, |Aⱼ| and whether the signs
//! differ are stored. Values are held in steps of [`STEP_RAD`], rounded down, so that the table never calls a
//! colliding cycle clear: table ≤ direct < table + step.
//!
//! | quantity | grid |
//! |---|---|
//! | φ₀ | −3.1, −3.0, … 3.1 rad; π and −π both lie nearest to an end |
//! | \|A\| | A_min, A_min + 0.1, … up to A_max, which is the last value |
//!
//! The file holds a magic word, the hash of everything the values depend on, their number, a checksum and the values,
//! little-endian. A file that does not fit in any of these is no table.
//!
//! Limits: between grid points the table is off by as much as the segment's ends are, [`LOOK_UP_RAD`]. So a search by it keeps
//! that much more distance, and every cycle that it finds is looked at again with the collision regions. 10 MB with
//! the default parameters; four offsets and amplitudes from 0 to π would be 65 MB.
//!
//! A look-up is faster than a direct evaluation, a whole plan is not: the direct search needs no room for the error of a grid, and
//! knows bounds that spare it most evaluations (`potential_field::gaps`). With three modules it takes some 800 plans, half an hour
//! of swimming, to win back the loading; with many it never happens (`cargo bench -p modboat --bench modboat`). So the direct search
//! is the default, and the table is there to reproduce the paper.

use std::f64::consts::TAU;

use super::distance::{DistanceToCollision, nearest_whole};
use super::motion::Swing;
use super::parameters::Parameters;
use super::region::DEPTH_RAD;

/// Distance of neighbouring grid values, rad. Paper, §II-A.
pub const GRID_RAD: f64 = 0.1;
/// The most that a look-up lies above the DoC of a swim cycle between grid points, where that is positive, rad: φ₀ and A of
/// both modules are off by half a grid step at most, the ends φ₀ ± A by one in each angle, and the DoC by √2 of them.
pub const LOOK_UP_RAD: f64 = GRID_RAD * std::f64::consts::SQRT_2;
/// Step of the stored values, rad.
pub const STEP_RAD: f64 = 0.5e-3;
/// Number of centerlines on the grid.
pub const CENTERLINES: usize = 63;
const MAGIC: [u8; 8] = *b"FlotDoC1";
const HEADER: usize = 32;

/// One module's swim cycle on the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridSwing {
    /// Index of φ₀, below [`CENTERLINES`].
    pub centerline: usize,
    /// Index of |A|, below [`DistanceTable::amplitudes`].
    pub amplitude: usize,
    /// True if A < 0.
    pub negative: bool,
}

/// DoC of every pair of swim cycles on the grid, for every reachable lattice offset.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceTable {
    offsets: usize,
    amplitude_min_rad: f64,
    amplitude_max_rad: f64,
    amplitudes: usize,
    /// In steps of STEP_RAD, by offset, φ₀ᵢ, φ₀ⱼ, |Aᵢ|, |Aⱼ|, sign.
    values: Vec<i16>,
}

/// The values of one offset and centerline φ₀ᵢ, to be computed.
#[derive(Debug)]
pub struct Row<'a> {
    table: &'a DistanceTable,
    direct: &'a DistanceToCollision,
    offset: usize,
    centerline: usize,
    values: &'a mut [i16],
}

impl DistanceTable {
    /// The table of these parameters, computed row by row.
    #[must_use]
    pub fn generate(parameters: &Parameters) -> Self {
        Self::generate_with(parameters, |rows| rows.into_iter().for_each(Row::compute))
    }

    /// The same; `compute` calls [`Row::compute`] for every row, in any order and on any thread.
    #[must_use]
    pub fn generate_with(parameters: &Parameters, compute: impl FnOnce(Vec<Row<'_>>)) -> Self {
        let direct = DistanceToCollision::new(parameters);
        let mut table = Self::empty(&direct, parameters);
        let mut values = vec![0; table.len()];
        let row = |(k, values)| Row {
            table: &table,
            direct: &direct,
            offset: k / CENTERLINES,
            centerline: k % CENTERLINES,
            values,
        };
        compute(values.chunks_mut(table.row()).enumerate().map(row).collect());
        table.values = values;
        table
    }

    /// Name of the file of the table of these parameters: it holds their hash.
    #[must_use]
    pub fn file_name(parameters: &Parameters) -> String {
        format!("doc-table-{:016x}.bin", parameter_hash(parameters))
    }

    /// The file of this table, which is one of these parameters.
    #[must_use]
    pub fn encode(&self, parameters: &Parameters) -> Vec<u8> {
        let body = || self.values.iter().flat_map(|value| value.to_le_bytes());
        let mut bytes = Vec::with_capacity(HEADER + 2 * self.values.len());
        bytes.extend(header(parameters, self.values.len(), fnv1a(body())));
        bytes.extend(body());
        bytes
    }

    /// The table in a file, if the file is whole and belongs to these parameters.
    #[must_use]
    pub fn decode(bytes: &[u8], parameters: &Parameters) -> Option<Self> {
        let mut table = Self::empty(&DistanceToCollision::new(parameters), parameters);
        let (found, body) = bytes.split_at_checked(HEADER)?;
        let expected = header(parameters, table.len(), fnv1a(body.iter().copied()));
        if found != expected || body.len() != 2 * table.len() {
            return None;
        }
        table.values = body.chunks_exact(2).map(|pair| i16::from_le_bytes([pair[0], pair[1]])).collect();
        Some(table)
    }

    fn empty(direct: &DistanceToCollision, parameters: &Parameters) -> Self {
        let (least, most) = (parameters.amplitude_min_rad, parameters.amplitude_max_rad);
        // A last step of less than 1e-6 of the grid is rounding, not a step.
        let amplitudes = ((most - least).max(0.0) / GRID_RAD - 1e-6).ceil().max(0.0) as usize + 1;
        Self {
            offsets: direct.offsets().len(),
            amplitude_min_rad: least,
            amplitude_max_rad: most,
            amplitudes,
            values: Vec::new(),
        }
    }

    /// Values of one centerline φ₀ᵢ.
    fn row(&self) -> usize {
        CENTERLINES * self.amplitudes * self.amplitudes * 2
    }

    /// Number of values.
    #[must_use]
    #[expect(
        clippy::len_without_is_empty,
        reason = "empty means that no tails can touch, which offsets() says"
    )]
    pub fn len(&self) -> usize {
        self.offsets * CENTERLINES * self.row()
    }

    /// Number of amplitudes |A| on the grid.
    #[must_use]
    pub fn amplitudes(&self) -> usize {
        self.amplitudes
    }

    /// Amplitude |A| number k, rad.
    #[must_use]
    pub fn amplitude_rad(&self, k: usize) -> f64 {
        (self.amplitude_min_rad + k as f64 * GRID_RAD).min(self.amplitude_max_rad)
    }

    /// DoC at a grid point, rad; NaN for an index beyond the grid.
    #[must_use]
    pub fn at(&self, offset_index: usize, i: GridSwing, j: GridSwing) -> f64 {
        let n = self.amplitudes;
        let within = |swing: GridSwing| swing.centerline < CENTERLINES && swing.amplitude < n;
        if !(within(i) && within(j)) {
            return f64::NAN;
        }
        let centerlines = (offset_index * CENTERLINES + i.centerline) * CENTERLINES + j.centerline;
        let place = ((centerlines * n + i.amplitude) * n + j.amplitude) * 2;
        let value = self.values.get(place + usize::from(i.negative != j.negative));
        value.map_or(f64::NAN, |&steps| f64::from(steps) * STEP_RAD)
    }

    /// The grid point nearest to a swim cycle. Amplitudes beyond the grid count as its ends.
    #[must_use]
    pub fn nearest(&self, Swing { centerline_rad, amplitude_rad }: Swing) -> GridSwing {
        let wrapped = centerline_rad - TAU * f64::from(nearest_whole(centerline_rad / TAU));
        let middle = (CENTERLINES / 2) as f64;
        // A conversion from f64 saturates, which is what is wanted at the ends.
        let steps = (amplitude_rad.abs() - self.amplitude_min_rad) / GRID_RAD;
        GridSwing {
            centerline: ((wrapped / GRID_RAD + middle + 0.5) as usize).min(CENTERLINES - 1),
            amplitude: ((steps + 0.5) as usize).min(self.amplitudes - 1),
            negative: amplitude_rad < 0.0,
        }
    }

    /// D(φ₀ᵢ, Aᵢ, φ₀ⱼ, Aⱼ) at the nearest grid point, rad.
    #[must_use]
    pub fn swim(&self, offset_index: usize, i: Swing, j: Swing) -> f64 {
        self.at(offset_index, self.nearest(i), self.nearest(j))
    }
}

impl Row<'_> {
    /// Number of values in the row.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "a row is never empty")]
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Computes the values of the row.
    pub fn compute(self) {
        let Self { table, direct, offset, centerline, values } = self;
        let mut values = values.iter_mut();
        let amplitudes = || (0..table.amplitudes).map(|k| table.amplitude_rad(k));
        let swing = |centerline_rad, amplitude_rad| Swing { centerline_rad, amplitude_rad };
        let centerline_i = centerline_rad(centerline);
        for centerline_j in (0..CENTERLINES).map(centerline_rad) {
            for i in amplitudes().map(|amplitude_i| swing(centerline_i, amplitude_i)) {
                for amplitude_j in amplitudes() {
                    for (amplitude_j, value) in [amplitude_j, -amplitude_j].into_iter().zip(values.by_ref()) {
                        let doc = direct.swim(offset, i, swing(centerline_j, amplitude_j));
                        // Saturates at ±16 rad; a DoC lies within −11 and 5.
                        *value = (doc / STEP_RAD).floor() as i16;
                    }
                }
            }
        }
    }
}

/// Centerline number k, rad.
#[must_use]
pub fn centerline_rad(k: usize) -> f64 {
    (k as f64 - (CENTERLINES / 2) as f64) * GRID_RAD
}

/// FNV-1a, 64 bits.
fn fnv1a(bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// Everything that the values depend on.
fn parameter_hash(parameters: &Parameters) -> u64 {
    let numbers = [
        parameters.pitch_m,
        parameters.tail_length_m,
        parameters.tail_width_m,
        parameters.amplitude_min_rad,
        parameters.amplitude_max_rad,
        GRID_RAD,
        STEP_RAD,
        DEPTH_RAD,
    ];
    fnv1a(MAGIC.into_iter().chain(numbers.into_iter().flat_map(f64::to_le_bytes)))
}

/// What a file of `count` values begins with.
fn header(parameters: &Parameters, count: usize, checksum: u64) -> Vec<u8> {
    let numbers = [parameter_hash(parameters), count as u64, checksum];
    MAGIC.into_iter().chain(numbers.into_iter().flat_map(u64::to_le_bytes)).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    use super::*;

    fn swing(centerline_rad: f64, amplitude_rad: f64) -> Swing {
        Swing { centerline_rad, amplitude_rad }
    }

    /// Two amplitudes only, so that a table takes a moment.
    fn small() -> Parameters {
        Parameters { amplitude_min_rad: 0.9, amplitude_max_rad: 1.0, ..Parameters::default() }
    }

    #[test]
    fn a_grid_point_holds_the_direct_value_rounded_down() {
        let direct = DistanceToCollision::new(&small());
        let table = DistanceTable::generate(&small());
        assert_eq!((table.len(), table.amplitudes()), (2 * 63 * 63 * 2 * 2 * 2, 2));
        let mut negatives = 0;
        for k in 0..20_000_usize {
            let (p, q, offset) = (k * 7 % CENTERLINES, k * 11 % CENTERLINES, k % 2);
            let (m, n, signs) = (k / 2 % 2, k / 4 % 2, k / 8 % 4);
            let (negative_i, negative_j) = (signs & 1 != 0, signs & 2 != 0);
            let signed = |k, negative: bool| table.amplitude_rad(k) * if negative { -1.0 } else { 1.0 };
            let (a, b) = (signed(m, negative_i), signed(n, negative_j));
            let exact = direct.swim(offset, swing(centerline_rad(p), a), swing(centerline_rad(q), b));
            let i = GridSwing { centerline: p, amplitude: m, negative: negative_i };
            let j = GridSwing { centerline: q, amplitude: n, negative: negative_j };
            let held = table.at(offset, i, j);
            // Run backwards, the sums round differently: 1e-9.
            assert!(held <= exact + 1e-9 && exact < held + STEP_RAD + 1e-9, "{i:?} {j:?}: {held}, {exact}");
            // Anything nearer than half a grid step, any number of turns away, is looked up there too.
            let moved = [swing(centerline_rad(p) + 0.03 + TAU, a + 0.04), swing(centerline_rad(q) - TAU, b)];
            let near = table.swim(offset, moved[0], moved[1]);
            assert!(near.to_bits() == held.to_bits(), "{i:?} {j:?}: {near}, {held}");
            negatives += u32::from(held < 0.0);
        }
        assert!((1000..19_000).contains(&negatives), "{negatives} of 20000 collide");
    }

    #[test]
    fn a_look_up_between_grid_points_is_off_by_less_than_it_is_said_to_be() {
        // Four amplitudes, so that there is something between them.
        let parameters = Parameters { amplitude_max_rad: 1.2, ..small() };
        let direct = DistanceToCollision::new(&parameters);
        let table = DistanceTable::generate(&parameters);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut most_rad = 0.0_f64;
        for k in 0..40_000 {
            let mut random = || {
                let amplitude = rng.random_range(0.9..1.2);
                swing(rng.random_range(-PI..PI), if rng.random() { amplitude } else { -amplitude })
            };
            let (i, j) = (random(), random());
            let (held, exact) = (table.swim(k % 2, i, j), direct.swim(k % 2, i, j));
            // Inside a region the DoC may jump.
            if held > LOOK_UP_RAD {
                assert!(held - exact <= LOOK_UP_RAD, "{k}: {held}, {exact}");
                most_rad = most_rad.max(held - exact);
            }
        }
        assert!(most_rad > 0.6 * LOOK_UP_RAD, "the bound is far from what happens: {most_rad}");
    }

    #[test]
    fn the_ends_of_the_grid_are_the_nearest_beyond_them() {
        let table =
            DistanceTable::empty(&DistanceToCollision::new(&Parameters::default()), &Parameters::default());
        assert_eq!(table.amplitudes(), 18);
        assert!((table.amplitude_rad(17) - 2.6).abs() < 1e-12);
        assert_eq!(table.len(), 2 * 63 * 63 * 18 * 18 * 2);
        let grid = |centerline, amplitude, negative| GridSwing { centerline, amplitude, negative };
        assert_eq!(table.nearest(swing(PI - 1e-3, -9.0)), grid(62, 17, true));
        assert_eq!(table.nearest(swing(1e-3 - PI, 0.1)), grid(0, 0, false));
        assert_eq!(table.nearest(swing(TAU, 0.96)), grid(31, 1, false));
        assert!(table.at(0, grid(63, 0, false), grid(0, 0, false)).is_nan());
    }

    #[test]
    fn a_file_is_trusted_only_if_whole_and_of_these_parameters() {
        let table = DistanceTable::generate(&small());
        let good = table.encode(&small());
        assert!(DistanceTable::decode(&good, &small()).as_ref() == Some(&table));
        let flipped = |place: usize| {
            let mut bytes = good.clone();
            bytes[place] ^= 0x10;
            bytes
        };
        // Magic, hash, number, checksum, a value; cut short, too long, empty.
        let mut spoilt: Vec<_> = [0, 9, 17, 25, 1000, good.len() - 1].map(flipped).to_vec();
        spoilt.extend([good[..good.len() - 2].to_vec(), [&good[..], &[0, 0]].concat(), Vec::new()]);
        for bytes in spoilt {
            assert!(DistanceTable::decode(&bytes, &small()).is_none());
        }
        let other = Parameters { tail_width_m: 0.014, ..small() };
        assert!(DistanceTable::decode(&good, &other).is_none());
        assert_ne!(DistanceTable::file_name(&other), DistanceTable::file_name(&small()));
    }
}
