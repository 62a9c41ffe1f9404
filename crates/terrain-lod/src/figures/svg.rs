//! A drawing in SVG: a few shapes on white, written in the order of drawing.

use std::fmt::Write;

/// A point of the drawing, in its units: x to the right, y downwards.
pub type Point = [f64; 2];

/// How a shape is filled and outlined.
#[derive(Clone, Copy)]
pub struct Paint {
    pub fill: &'static str,
    pub stroke: &'static str,
    pub width: f64,
}

/// A drawing under way.
pub struct Drawing {
    size: [f64; 2],
    shapes: String,
}

impl Drawing {
    pub fn new(width: f64, height: f64) -> Self {
        Self { size: [width, height], shapes: String::new() }
    }

    pub fn polygon(&mut self, corners: &[Point], Paint { fill, stroke, width }: Paint) {
        let points: Vec<String> = corners.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(
            self.shapes,
            "<polygon points=\"{}\" fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\"{width}\"/>",
            points.join(" ")
        );
    }

    pub fn line(&mut self, [from, to]: [Point; 2], stroke: &str, width: f64) {
        let _ = writeln!(
            self.shapes,
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{stroke}\" stroke-width=\"{width}\"/>",
            from[0], from[1], to[0], to[1]
        );
    }

    pub fn circle(&mut self, [x, y]: Point, radius: f64, Paint { fill, stroke, width }: Paint) {
        let _ = writeln!(
            self.shapes,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\"{width}\"/>"
        );
    }

    /// Text in the middle of a point. It must be free of markup.
    pub fn text(&mut self, [x, y]: Point, size: f64, colour: &str, text: &str) {
        let baseline = y + 0.36 * size;
        let _ = writeln!(
            self.shapes,
            "<text x=\"{x:.1}\" y=\"{baseline:.1}\" font-size=\"{size}\" fill=\"{colour}\" text-anchor=\"middle\">{text}</text>"
        );
    }

    /// The same on a light rim, over lines.
    pub fn text_on_lines(&mut self, at: Point, size: f64, colour: &str, text: &str) {
        self.shapes += "<g stroke=\"white\" stroke-width=\"4\" paint-order=\"stroke\">";
        self.text(at, size, colour, text);
        self.shapes += "</g>\n";
    }

    /// The whole file. `title` must be free of markup.
    pub fn finish(self, title: &str) -> String {
        let [width, height] = self.size;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
             role=\"img\" font-family=\"sans-serif\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n<title>{title}</title>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n{}</svg>\n",
            self.shapes
        )
    }
}
