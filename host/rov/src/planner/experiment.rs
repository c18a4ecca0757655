
use super::pricer::Pricer;
use super::super::order::{Hop, MOST};
use super::super::order::assignment::Assignment;
use std::collections::HashMap;

pub struct Table { pub n: usize, pub base: Vec<f64>, pub obs: Vec<Vec<(u32, f64)>>, }

impl Pricer<'_> {
    pub fn experiment(&self, best: f64) {
        let t0 = std::time::Instant::now();
        let n = self.layout.robots();
        // bodies: groups of same seat pose
        let mut base = vec![f64::INFINITY; n * n];
        let mut obs = vec![Vec::new(); n * n];
        let pose = |p: usize| self.places.pose(p);
        let same = |a: usize, b: usize| { let (a, b) = (pose(a), pose(b)); (0..3).all(|k| (a.position_m[k]-b.position_m[k]).abs()<1e-6) };
        // distinct obstacles: starts, then slots not same as a start
        let mut bodies: Vec<(usize, u32)> = (0..n).map(|i| (i, 1u32 << i)).collect();
        for s in 0..n {
            if let Some(b) = bodies.iter_mut().find(|(p, _)| *p < n && same(*p, n + s)) { b.1 |= 1 << (16 + s); }
            else { bodies.push((n + s, 1 << (16 + s))); }
        }
        let mut routes = 0;
        for i in 0..n { for s in 0..n {
            let hop = Hop::new(i, n + s);
            let Some(b0) = self.bound_of(i, 0, n + s) else { continue };
            base[i * n + s] = b0;
            if self.stays(hop) { continue; }
            for &(p, mask) in &bodies {
                if p == i || p == n + s || mask >> i & 1 == 1 { continue; }
                if mask >> (16 + s) & 1 == 1 { obs[i*n+s].push((1u32 << (mask.trailing_zeros()), f64::INFINITY)); continue; }
                let c = self.cost_beside(0, hop, 0, self.places.seat(p, 0));
                let e = c - b0;
                routes += 1;
                if e > 1e-6 * b0 { obs[i * n + s].push((mask, e)); }
            }
            self.routes.share();
        }}
        // a start that rests at i blocked for slot equal to another's start
        let total: usize = obs.iter().map(Vec::len).sum();
        eprintln!("EXP tables {:.2} s, {routes} asked, {total} obstacles", t0.elapsed().as_secs_f64());
        let mut costs = [[f64::INFINITY; MOST]; MOST];
        for i in 0..n { for s in 0..n { costs[i][s] = base[i*n+s]; } }
        let a = Assignment::new(&costs, n, n).unwrap();
        // duals through reduced
        let (u, v) = a.duals(&costs);
        eprintln!("EXP assignment {:.2} duals {:.2}", a.cost, u[..n].iter().sum::<f64>() + v[..n].iter().sum::<f64>());
        let t = Table { n, base, obs };
        let all: u32 = ((1u64 << n) - 1) as u32;
        let red = |i: usize, s: usize| t.base[i*n+s] - u[i] - v[s];
        // importance of bits
        let mut weight = [0.0; 32];
        for i in 0..n { for s in 0..n {
            let r = red(i, s); if !r.is_finite() || r > 15.0 { continue; }
            let w = (-r / 8.0).exp();
            for &(m, e) in &t.obs[i*n+s] {
                if !e.is_finite() { continue; }
                let each = w * e.min(40.0);
                for b in 0..32 { if m >> b & 1 == 1 { weight[b] += each; } }
            }
        }}
        eprintln!("weights {weight:.0?}");
        for m in [12, 16, 18, 20, 22] {
          for mode in 0..2 {
            let t1 = std::time::Instant::now();
            let mut order: Vec<usize> = (0..n).chain(16..16 + n).collect();
            match mode {
                0 => order.sort_by(|&a, &b| weight[b].total_cmp(&weight[a])),
                _ => {
                    // alternately starts and slots by weight
                    let mut st: Vec<usize> = (0..n).collect(); st.sort_by(|&a, &b| weight[b].total_cmp(&weight[a]));
                    let mut sl: Vec<usize> = (16..16+n).collect(); sl.sort_by(|&a, &b| weight[b].total_cmp(&weight[a]));
                    order = st.iter().zip(&sl).flat_map(|(a, b)| [*a, *b]).collect();
                }
            }
            let tracked = &order[..m];
            // compact index k -> bit
            let pos = |bit: usize| tracked.iter().position(|&b| b == bit);
            let starts_mask: u32 = (0..m).filter(|&k| tracked[k] < 16).map(|k| 1u32 << k).sum();
            // hops: (bits cleared, r0, obstacles over compact: present if (x ^ flip) & mask)
            struct H { clear: u32, r0: f32, obs: Vec<(u32, f32)> }
            let mut by: HashMap<u32, Vec<H>> = HashMap::new();
            for i in 0..n { for s in 0..n {
                let r = red(i, s); if !r.is_finite() { continue; }
                let (ci, cs) = (pos(i), pos(16 + s));
                let clear = ci.map_or(0, |k| 1u32 << k) | cs.map_or(0, |k| 1u32 << k);
                if clear == 0 { continue; }
                let mut obs: Vec<(u32, f32)> = t.obs[i*n+s].iter().filter_map(|&(mask, e)| {
                    let c: u32 = (0..m).filter(|&k| mask >> tracked[k] & 1 == 1).map(|k| 1u32 << k).sum();
                    (c != 0).then_some((c, e as f32))
                }).collect();
                obs.sort_by(|a, b| b.1.total_cmp(&a.1));
                by.entry(clear).or_default().push(H { clear, r0: r as f32, obs });
            }}
            let hops: Vec<H> = by.into_values().flatten().collect();
            let mut d = vec![f32::INFINITY; 1 << m];
            d[0] = 0.0;
            for x in 1..1u32 << m {
                // present: starts remaining (bit set), slots filled (bit clear)
                let present = (x & starts_mask) | (!x & !starts_mask);
                let mut least = f32::INFINITY;
                for h in &hops {
                    if h.clear & x != h.clear { continue; }
                    let before = d[(x & !h.clear) as usize] + h.r0;
                    if before >= least { continue; }
                    let p = present & !h.clear;
                    let e = h.obs.iter().find(|o| o.0 & p != 0).map_or(0.0, |o| o.1);
                    if before + e < least { least = before + e; }
                }
                d[x as usize] = least;
            }
            eprintln!("EXP pdb {m} mode {mode}: {:.2}  hops {} {:.2} s", a.cost + f64::from(d[(1usize << m) - 1]), hops.len(), t1.elapsed().as_secs_f64());
          }
        }
        for width in [100, 1000] {
            let mut layer: HashMap<u32, f64> = HashMap::new();
            layer.insert(all, 0.0);
            for _ in 0..n {
                let mut next: HashMap<u32, f64> = HashMap::new();
                for (&st, &g) in &layer {
                    for i in 0..n { if st >> i & 1 == 0 { continue; }
                        for s in 0..n { if st >> (16 + s) & 1 == 1 { continue; }
                            let c = t.base[i*n+s]; if !c.is_finite() { continue; }
                            let e = t.obs[i*n+s].iter().filter(|(m, _)| m & st != 0).map(|o| o.1).fold(0.0, f64::max);
                            if !e.is_finite() { continue; }
                            let r = g + c - u[i] - v[s] + e;
                            let to = st & !(1 << i) | 1 << (16 + s);
                            let x = next.entry(to).or_insert(f64::INFINITY);
                            if r < *x { *x = r; }
                        }
                    }
                }
                let mut all: Vec<(u32, f64)> = next.into_iter().collect();
                all.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
                all.truncate(width);
                layer = all.into_iter().collect();
            }
            let least = layer.values().copied().fold(f64::INFINITY, f64::min);
            eprintln!("EXP beam {width}: relaxed {:.2} (plan {best:.2}) {:.2} s", a.cost + least, t0.elapsed().as_secs_f64());
        }
    }
}
