//! A part of a picture on which a scene is painted: from the world to px, and the shapes.

use plotters::element::{Circle, PathElement, Polygon};
use plotters::style::{RGBColor, ShapeStyle, TextStyle};

use super::solid::{Solid, Vec3, View};
use crate::lines::Point;
use crate::picture::{Area, DrawError};
use crate::style;

/// Where a scene is painted, and how large.
pub struct Stage<'s, 'a> {
    /// The part of the picture.
    pub area: &'s Area<'a>,
    /// From where the scene is seen.
    pub view: View,
    /// px of a metre.
    pub scale: f64,
    /// Where the world's origin is seen (right, down), px.
    pub origin: Point,
}

impl Stage<'_, '_> {
    /// Where a point is painted (right, down), px.
    #[must_use]
    pub fn at(&self, p: Vec3) -> Point {
        let (right, up) = self.view.project(p);
        (self.origin.0 + self.scale * right, self.origin.1 - self.scale * up)
    }

    fn grid(p: Point) -> (i32, i32) {
        (style::px(p.0), style::px(p.1))
    }

    /// A line through points of the world.
    pub fn line(&self, points: &[Vec3], line: ShapeStyle) -> Result<(), DrawError> {
        if points.len() < 2 {
            return Ok(());
        }
        let points: Vec<_> = points.iter().map(|&p| Self::grid(self.at(p))).collect();
        self.area.draw(&PathElement::new(points, line))
    }

    /// A closed line through points of the world.
    pub fn ring(&self, points: &[Vec3], line: ShapeStyle) -> Result<(), DrawError> {
        let closed: Vec<Vec3> = points.iter().chain(points.first()).copied().collect();
        self.line(&closed, line)
    }

    /// A filled polygon between points of the world.
    pub fn polygon(&self, points: &[Vec3], fill: ShapeStyle) -> Result<(), DrawError> {
        if points.len() < 3 {
            return Ok(());
        }
        let points: Vec<_> = points.iter().map(|&p| Self::grid(self.at(p))).collect();
        self.area.draw(&Polygon::new(points, fill))
    }

    /// A disc of that radius in px, `offset` px (right, down) from a point of the world.
    pub fn disc(&self, at: Vec3, offset: Point, radius_px: f64, colour: RGBColor) -> Result<(), DrawError> {
        let (x, y) = self.at(at);
        let centre = Self::grid((x + offset.0, y + offset.1));
        self.area.draw(&Circle::new(centre, style::size(radius_px), style::fill(colour, 1.0)))
    }

    /// A text with `offset` px (right, down) from a point of the world.
    pub fn text(&self, text: &str, at: Vec3, offset: Point, look: &TextStyle<'_>) -> Result<(), DrawError> {
        let (x, y) = self.at(at);
        self.area.draw_text(text, look, Self::grid((x + offset.0, y + offset.1)))
    }

    /// The faces of a solid that the viewer sees, each darker the further its normal points down or aside.
    pub fn hull(&self, solid: &Solid, colour: RGBColor) -> Result<(), DrawError> {
        for face in solid.faces(&self.view).iter().filter(|f| f.is_seen) {
            let shade = [0.16, 0.32, 0.0][face.axis];
            self.polygon(&face.corners, style::fill(blend(colour, style::INK, shade), 1.0))?;
        }
        self.edges(solid, style::line(plotters::style::WHITE, 0.75, 0.75))
    }

    /// The edges of a solid that the viewer sees.
    pub fn edges(&self, solid: &Solid, line: ShapeStyle) -> Result<(), DrawError> {
        let faces = solid.faces(&self.view);
        let seen = |axis: usize, high: bool| faces[2 * axis + usize::from(!high)].is_seen;
        for axis in 0..3 {
            let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
            for (b, c) in [(false, false), (false, true), (true, false), (true, true)] {
                // An edge is seen if one of its two faces is.
                if seen(second, b) || seen(third, c) {
                    let end = |a: f64| {
                        let mut share = [a; 3];
                        share[second] = if b { 1.0 } else { -1.0 };
                        share[third] = if c { 1.0 } else { -1.0 };
                        solid.at(share)
                    };
                    self.line(&[end(-1.0), end(1.0)], line)?;
                }
            }
        }
        Ok(())
    }
}

/// A colour with a share of another.
#[must_use]
pub fn blend(colour: RGBColor, other: RGBColor, share: f64) -> RGBColor {
    let mix = |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
    RGBColor(mix(colour.0, other.0), mix(colour.1, other.1), mix(colour.2, other.2))
}
