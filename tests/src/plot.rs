//! Plots for the book: lines over two logarithmic axes, as SVG that suits light and dark pages.

use std::fmt::Write;

/// Values over values, both positive.
pub struct LogPlot<'a> {
    /// What is to the right.
    pub x: &'a str,
    /// What is up.
    pub y: &'a str,
    /// Names, points, and whether they are a bound, which is dashed.
    pub lines: &'a [(&'a str, Vec<[f64; 2]>, bool)],
}

const SIZE: [f64; 2] = [640.0, 400.0];
/// Left, top, right, bottom.
const MARGIN: [f64; 4] = [70.0, 16.0, 190.0, 50.0];
const COLORS: [&str; 4] = ["#3b76c4", "#c2573a", "#3f9160", "#8a8a8a"];

impl LogPlot<'_> {
    /// The picture.
    pub fn svg(&self) -> String {
        let points = || self.lines.iter().flat_map(|line| line.1.iter());
        let span = |axis: usize| {
            let logs = points().map(|point| point[axis].log10());
            logs.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], value| [a.min(value), b.max(value)])
        };
        let [left, top, right, bottom] = MARGIN;
        let (x, y) = (span(0), span(1).map(|value| value + 0.0));
        // Whole powers of ten upwards; to the right what there is.
        let y = [y[0].floor(), y[1].ceil()];
        let place = |[a, b]: [f64; 2]| {
            let share = |value: f64, [first, last]: [f64; 2]| (value.log10() - first) / (last - first).max(1e-9);
            let [width, height] = [SIZE[0] - left - right, SIZE[1] - top - bottom];
            [left + width * share(a, x), top + height * (1.0 - share(b, y))]
        };
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"13\" \
             fill=\"#777\">\n",
            SIZE[0], SIZE[1]
        );
        let mut line = |text: String| writeln!(out, "{text}").unwrap_or_default();
        for power in y[0] as i32..=y[1] as i32 {
            let [_, at] = place([1.0, 10_f64.powi(power)]);
            line(format!("<path d=\"M{left} {at:.1}H{}\" stroke=\"#8886\"/>", SIZE[0] - right));
            line(format!(
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">10<tspan dy=\"-5\" font-size=\"10\">{power}</tspan></text>",
                left - 8.0,
                at + 4.0
            ));
        }
        let mut ticks: Vec<f64> = points().map(|point| point[0]).collect();
        ticks.sort_by(f64::total_cmp);
        ticks.dedup();
        for tick in ticks {
            let [at, _] = place([tick, 1.0]);
            let floor = SIZE[1] - bottom;
            line(format!("<path d=\"M{at:.1} {floor}v-{}\" stroke=\"#8886\"/>", floor - top));
            line(format!("<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{tick}</text>", floor + 18.0));
        }
        let middle = [(left + SIZE[0] - right) / 2.0, (top + SIZE[1] - bottom) / 2.0];
        line(format!("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>", middle[0], SIZE[1] - 10.0, self.x));
        line(format!(
            "<text transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            middle[1], self.y
        ));
        for (index, (name, points, is_bound)) in self.lines.iter().enumerate() {
            let color = COLORS[index % COLORS.len()];
            let dash = if *is_bound { " stroke-dasharray=\"5 4\"" } else { "" };
            let path: Vec<String> = points.iter().map(|&p| place(p).map(|c| format!("{c:.1}")).join(" ")).collect();
            line(format!(
                "<path d=\"M{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"{dash}/>",
                path.join("L")
            ));
            for [cx, cy] in points.iter().filter(|_| !is_bound).map(|&point| place(point)) {
                line(format!("<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"3.5\" fill=\"{color}\"/>"));
            }
            if let Some([end, at]) = points.last().map(|&point| place(point)) {
                line(format!("<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{color}\">{name}</text>", end + 10.0, at + 4.0));
            }
        }
        out + "</svg>\n"
    }
}
