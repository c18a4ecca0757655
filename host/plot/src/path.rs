//! A 2D map with paths on it: blocked cells, and each path from its dot to its ring. x to the right, y down, as in the
//! text of the map.

use grid::plane::Plane;
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::WHITE;

use super::picture::{self, Area, DrawError, Heading};
use super::style;

/// Longest side of a map, px.
const SIDE: f64 = 860.0;
/// Least width of a picture, so that its heading has room, px.
const WIDTH_MIN: f64 = 560.0;
/// More paths than this are drawn thin, and without their ends.
const MANY: usize = 40;

/// Draws the picture of a map called `name`, with `line` under its name.
pub fn svg(name: &str, line: String, plane: &Plane, paths: &[Vec<[u32; 2]>]) -> Result<String, DrawError> {
    let (width, height) = (f64::from(plane.width()), f64::from(plane.height()));
    let cell_px = (SIDE / width.max(height)).min(48.0);
    let (body_width, _) = picture::body_size((0.0, 0.0));
    let size = (
        (width * cell_px - 2.0 * body_width).max(WIDTH_MIN),
        // A pixel for the frame.
        picture::height_for(height * cell_px + 2.0),
    );
    let heading = Heading { name, subject: "paths", line };
    picture::render(size, &heading, |area| {
        let left = (picture::area_size(area).0 - width * cell_px) / 2.0;
        let at = |x: u32, y: u32| {
            (style::px(left + f64::from(x) * cell_px), style::px(1.0 + f64::from(y) * cell_px))
        };
        let whole = [at(0, 0), at(plane.width(), plane.height())];
        area.draw(&Rectangle::new(whole, style::fill(style::GRID, 0.4)))?;
        blocks(area, plane, at)?;
        area.draw(&Rectangle::new(whole, style::line(style::FRAME, 1.0, 1.0)))?;
        let is_many = paths.len() > MANY;
        let (opacity, width_px) = if is_many { (0.35, 1.0) } else { (1.0, 2.0) };
        for (index, path) in paths.iter().enumerate() {
            let points = path.iter().map(|&[x, y]| at(x, y)).collect::<Vec<_>>();
            let line = style::line(style::module_colour(index), opacity, width_px);
            area.draw(&PathElement::new(points, line))?;
        }
        for (index, path) in paths.iter().enumerate().filter(|_| !is_many) {
            let colour = style::module_colour(index);
            let [Some(&[x, y]), Some(&[goal_x, goal_y])] = [path.first(), path.last()] else { continue };
            let disc = |at, radius_px, colour| {
                area.draw(&Circle::new(at, style::size(radius_px), style::fill(colour, 1.0)))
            };
            disc(at(x, y), 4.5, colour)?;
            disc(at(goal_x, goal_y), 4.5, colour)?;
            disc(at(goal_x, goal_y), 2.5, WHITE)?;
        }
        Ok(())
    })
}

/// Blocked cells, a row's neighbours in one piece, and equal pieces of rows below each other too.
fn blocks(area: &Area<'_>, plane: &Plane, at: impl Fn(u32, u32) -> (i32, i32)) -> Result<(), DrawError> {
    // Pieces that may go on below: from and to which x, and since which y.
    let mut above: Vec<(u32, u32, u32)> = Vec::new();
    for y in 0..=plane.height() {
        let mut row = Vec::new();
        let mut x = 0;
        while y < plane.height() && x < plane.width() {
            let from = x;
            while x < plane.width() && !plane.is_free(x, y) {
                x += 1;
            }
            if x > from {
                let since = above.iter().find(|piece| (piece.0, piece.1) == (from, x));
                row.push((from, x, since.map_or(y, |piece| piece.2)));
            }
            x += 1;
        }
        for &(from, to, since) in above.iter().filter(|piece| !row.contains(piece)) {
            area.draw(&Rectangle::new([at(from, since), at(to, y)], style::fill(style::HULL, 0.75)))?;
        }
        above = row;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_block_and_every_path_is_drawn_once() {
        let rows = ["##..", "##.#", ".#.."];
        let is_free = |x: u32, y: u32| rows[y as usize].as_bytes()[x as usize] == b'.';
        let plane = Plane::new(4, 3, is_free).expect("a map");
        let paths = [vec![[2, 0], [2, 3]], vec![[0, 2], [0, 3], [1, 3]]];
        let picture = svg("a <map>", "two paths".to_owned(), &plane, &paths).expect("a picture");
        // Background, map, frame; the square of four, the single ones below it and beside it.
        assert_eq!(picture.matches("<rect").count(), 3 + 3, "{picture}");
        assert_eq!(picture.matches("<polyline").count(), 2);
        assert_eq!(picture.matches("<circle").count(), 6);
        assert!(picture.contains("a &lt;map&gt; · paths"));
        // Many paths: lines only.
        let many = vec![paths[0].clone(); MANY + 1];
        let picture = svg("m", String::new(), &plane, &many).expect("a picture");
        assert_eq!((picture.matches("<polyline").count(), picture.matches("<circle").count()), (MANY + 1, 0));
    }
}
