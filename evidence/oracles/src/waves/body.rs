//! A body: sections end to end, each a pair of delay lines. Where the impedance changes from `Z1` to `Z2` downward, a
//! velocity wave is transmitted by the factor `2 Z1 / (Z1 + Z2)` and reflected by `(Z1 - Z2) / (Z1 + Z2)`.

use super::Section;
use super::line::Line;

/// A wave at the beginning and at the end of a step, linear between.
pub type Chord = [f64; 2];

/// A body of one or more sections.
#[derive(Clone, Debug)]
pub struct Body {
    sections: Vec<Section>,
    /// Lines of each section, downward and upward.
    lines: Vec<[Line; 2]>,
}

impl Body {
    /// A bar of some `sections`. Each line follows from the section's transit and from its waves before time 0,
    /// downward and upward: those of a bar that moves with a velocity, is pressed by a force at its top, and by its
    /// weight in `gravity` below.
    pub fn new(
        sections: &[Section],
        (velocity, mut force, gravity): (f64, f64, f64),
        line: impl Fn(f64, Chord) -> Line,
    ) -> Self {
        let lines = sections.iter().map(|&Section { impedance, transit }| {
            let content = |sign: f64, force: f64| {
                let value = 0.5 * velocity + sign * 0.5 * force / impedance;
                line(transit, [value, -0.5 * gravity])
            };
            let down = content(1.0, force);
            force += impedance * transit * gravity;
            [down, content(-1.0, force)]
        });
        Self { lines: lines.collect(), sections: sections.to_vec() }
    }

    /// The wave that arrives at the top.
    pub fn top(&self) -> &Line {
        &self.lines[0][1]
    }

    /// The wave that arrives at the bottom.
    pub fn bottom(&self) -> &Line {
        &self.lines[self.lines.len() - 1][0]
    }

    /// Sends waves in at the top and the bottom, and transmits and reflects those inside at each change of section.
    pub fn send(&mut self, time: f64, end: f64, [top, bottom]: [Chord; 2]) {
        let out = |line: &Line| [line.after(time), line.before(end)];
        let steps = self.lines.windows(2).zip(self.sections.windows(2));
        let passed: Vec<[Chord; 2]> = steps
            .map(|(lines, sections)| {
                let [above, below] = [sections[0].impedance, sections[1].impedance];
                let (down, up) = (out(&lines[0][0]), out(&lines[1][1]));
                let part = |x: f64| x / (above + below);
                [
                    [0, 1].map(|k| part(2.0 * above * down[k] + (below - above) * up[k])),
                    [0, 1].map(|k| part((above - below) * down[k] + 2.0 * below * up[k])),
                ]
            })
            .collect();
        for (i, [down, up]) in self.lines.iter_mut().enumerate() {
            let [first, last] = if i == 0 { top } else { passed[i - 1][0] };
            down.send(time, end, first, last);
            let [first, last] = passed.get(i).map_or(bottom, |step| step[1]);
            up.send(time, end, first, last);
        }
    }

    /// The waves downward and upward in a section, at a fraction of its length below its top.
    pub fn inside(&self, time: f64, section: usize, part: f64) -> [f64; 2] {
        let transit = self.sections[section].transit;
        let [down, up] = &self.lines[section];
        [down.sent(time - part * transit), up.sent(time - (1.0 - part) * transit)]
    }
}
