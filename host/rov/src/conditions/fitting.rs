//! Whether robots of several kinds fit into the slots without boxes in each other: a search over assignments that gives up
//! a branch at the first overlap.

/// Looks at most before the question is left open.
const MOST: usize = 200_000;

/// Whether some assignment of `robots` to slots leaves no two boxes in each other; `None` if that was not decided.
///
/// `fits(robot, slot)` says whether a robot may be there at all, `clash(a, b)` whether two placed robots, each a robot and
/// its slot, are in each other.
pub(super) fn is_possible(
    robots: usize,
    slots: usize,
    fits: &impl Fn(usize, usize) -> bool,
    clash: &impl Fn((usize, usize), (usize, usize)) -> bool,
) -> Option<bool> {
    let mut looks = 0;
    let found = place(&mut Vec::with_capacity(robots), (robots, slots), fits, clash, &mut looks);
    if found || looks < MOST { Some(found) } else { None }
}

fn place(
    placed: &mut Vec<(usize, usize)>,
    (robots, slots): (usize, usize),
    fits: &impl Fn(usize, usize) -> bool,
    clash: &impl Fn((usize, usize), (usize, usize)) -> bool,
    looks: &mut usize,
) -> bool {
    let robot = placed.len();
    if robot == robots {
        return true;
    }
    for slot in 0..slots {
        *looks += 1;
        if *looks >= MOST {
            return false;
        }
        let own = (robot, slot);
        if fits(robot, slot) && placed.iter().all(|&other| other.1 != slot && !clash(own, other)) {
            placed.push(own);
            if place(placed, (robots, slots), fits, clash, looks) {
                return true;
            }
            placed.pop();
        }
    }
    false
}
