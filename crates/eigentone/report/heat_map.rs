//! A heat map as SVG: how many digits each method keeps at each value of a parameter.

use std::fmt::Write;

use super::plot::{FONT, escape, shorten};

/// Rows of tiles, one row for each method, one column for each value.
pub(crate) struct HeatMap {
    /// What stands above it.
    pub(crate) title: String,
    /// A sentence below the title.
    pub(crate) about: String,
    /// What the columns differ in.
    pub(crate) parameter: String,
    /// A label for each column.
    pub(crate) columns: Vec<String>,
    /// Groups of rows, each under its own word.
    pub(crate) groups: Vec<(String, Vec<Row>)>,
}

/// One method.
pub(crate) struct Row {
    pub(crate) name: String,
    /// Whether the name stands out.
    pub(crate) strong: bool,
    pub(crate) tiles: Vec<Tile>,
}

/// One tile.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Tile {
    /// So many digits are right, of 16.
    Digits(u32),
    /// The answer is wrong, or there is none.
    Broken,
    /// Not run, and why in a few letters.
    Left(String),
    /// It does not apply.
    Absent,
}

const WIDTH: f64 = 960.0;
/// Where the tiles begin and end.
const LEFT: f64 = 232.0;
const RIGHT: f64 = WIDTH - 24.0;
const TOP: f64 = 76.0;
const TILE: f64 = 30.0;
const GROUP: f64 = 30.0;
/// Letters of a name and of the sentence that fit.
const LETTERS: usize = 27;
const SENTENCE: usize = 130;

/// From no digit to sixteen, after cividis (Nuñez, Anderton & Renslow 2018), which colour-blind readers
/// see as others do.
const COLOURS: [&str; 9] = [
    "#fee838", "#e1cc55", "#c3b369", "#a69d75", "#8a8779", "#707173", "#575d6d", "#3b496c",
    "#00306f",
];
const MOST: u32 = 16;

impl HeatMap {
    /// The heat map as one SVG document with a `viewBox`, on a white card.
    pub(crate) fn svg(&self) -> String {
        let rows: usize = self.groups.iter().map(|(_, rows)| rows.len()).sum();
        let bottom = TOP + GROUP * self.groups.len() as f64 + TILE * rows as f64;
        let height = bottom + 108.0;
        let mut svg = format!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img" aria-labelledby="title" font-family="{FONT}" font-size="13" fill="#222222">
<title id="title">{title}</title>
<defs><pattern id="hatch" width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)"><path d="M0 0V6" stroke="#c8c8c8" stroke-width="2"/></pattern></defs>
<rect x="0.5" y="0.5" width="{}" height="{}" rx="8" fill="#ffffff" stroke="#d0d0d0"/>
<text x="24" y="34" font-size="18" font-weight="600">{title}</text>
<text x="24" y="60" fill="#444444">{}</text>
"##,
            WIDTH - 1.0,
            height - 1.0,
            escape(&shorten(&self.about, SENTENCE)),
            title = escape(&shorten(&self.title, 88)),
        );
        let mut y = TOP;
        for (word, rows) in &self.groups {
            let _ = writeln!(
                svg,
                r##"<text x="24" y="{:.1}" font-weight="600" fill="#444444">{}</text>"##,
                y + 19.0,
                escape(word)
            );
            y += GROUP;
            for row in rows {
                self.row(&mut svg, row, y);
                y += TILE;
            }
        }
        self.axis(&mut svg, bottom);
        legend(&mut svg, bottom + 76.0);
        svg.push_str("</svg>\n");
        svg
    }

    fn width(&self) -> f64 {
        (RIGHT - LEFT) / self.columns.len().max(1) as f64
    }

    fn row(&self, svg: &mut String, row: &Row, y: f64) {
        let weight = if row.strong { 600 } else { 400 };
        let _ = writeln!(
            svg,
            r##"<text x="{}" y="{:.1}" text-anchor="end" font-weight="{weight}">{}</text>"##,
            LEFT - 10.0,
            y + TILE / 2.0 + 4.5,
            escape(&shorten(&row.name, LETTERS))
        );
        for (column, tile) in row.tiles.iter().enumerate() {
            let x = LEFT + self.width() * column as f64;
            draw(svg, tile, x, y, self.width());
        }
    }

    fn axis(&self, svg: &mut String, bottom: f64) {
        for (column, label) in self.columns.iter().enumerate() {
            let _ = writeln!(
                svg,
                r##"<text x="{:.1}" y="{:.1}" text-anchor="middle">{}</text>"##,
                LEFT + self.width() * (column as f64 + 0.5),
                bottom + 18.0,
                escape(label)
            );
        }
        let _ = writeln!(
            svg,
            r##"<text x="{:.1}" y="{:.1}" text-anchor="middle">{}</text>"##,
            f64::midpoint(LEFT, RIGHT),
            bottom + 42.0,
            escape(&self.parameter)
        );
    }
}

fn draw(svg: &mut String, tile: &Tile, x: f64, y: f64, width: f64) {
    let (fill, ink, text) = match tile {
        Tile::Digits(digits) => {
            let digits = (*digits).min(MOST);
            let shade = (digits * (COLOURS.len() as u32 - 1) + MOST / 2) / MOST;
            let ink = if shade >= 4 { "#ffffff" } else { "#222222" };
            (COLOURS[shade as usize], ink, digits.to_string())
        }
        Tile::Broken => ("#222222", "#ffffff", "×".to_owned()),
        Tile::Left(text) => ("url(#hatch)", "#444444", text.clone()),
        Tile::Absent => ("#ffffff", "#888888", "–".to_owned()),
    };
    let centre = x + width / 2.0;
    let _ = write!(
        svg,
        r##"<rect x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{TILE}" fill="{fill}" stroke="#ffffff" stroke-width="1"/>"##
    );
    if let Tile::Left(_) = tile {
        let room = 8.0 * text.chars().count() as f64 + 6.0;
        let _ = write!(
            svg,
            r##"<rect x="{:.1}" y="{:.1}" width="{room:.1}" height="18" rx="4" fill="#ffffff"/>"##,
            centre - room / 2.0,
            y + TILE / 2.0 - 9.0
        );
    }
    let _ = writeln!(
        svg,
        r##"<text x="{centre:.1}" y="{:.1}" text-anchor="middle" fill="{ink}">{}</text>"##,
        y + TILE / 2.0 + 4.5,
        escape(&text)
    );
}

fn legend(svg: &mut String, y: f64) {
    const SAMPLE: f64 = 34.0;
    let mut x = 24.0;
    let mut entry = |tiles: &[Tile], text: &str, room: f64| {
        for tile in tiles {
            draw(svg, tile, x, y - TILE / 2.0, SAMPLE);
            x += SAMPLE;
        }
        let _ = writeln!(
            svg,
            r##"<text x="{:.1}" y="{:.1}">{text}</text>"##,
            x + 8.0,
            y + 4.5
        );
        x += room;
    };
    let digits = [0, 4, 8, 12, 16].map(Tile::Digits);
    entry(&digits, "digits right", 104.0);
    entry(&[Tile::Broken], "wrong, unstable or no answer", 212.0);
    entry(
        &[Tile::Left("10⁹".to_owned())],
        "not run: steps it would take",
        206.0,
    );
    entry(&[Tile::Absent], "does not apply", 100.0);
}
