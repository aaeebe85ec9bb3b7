//! A log as a table that tests spoil, as public logs of real arms are.

use crate::terminal::{Said, Terminal, assert_says};

#[derive(Clone)]
pub(crate) struct Table {
    /// Comments before the header.
    notes: String,
    header: Vec<String>,
    pub(crate) rows: Vec<Vec<f64>>,
}

impl Table {
    /// Two joints on sums of sines: 20 s at 100 Hz.
    pub(crate) fn arm() -> Self {
        Self::simulated("planar-2 --motion sines --seconds 20 --rate 100 --seed 4")
    }

    pub(crate) fn simulated(how: &str) -> Self {
        let terminal = Terminal::new();
        terminal.done(&format!("simulate {how} -o arm.csv"));
        Self::of(&terminal, "arm.csv")
    }

    pub(crate) fn of(terminal: &Terminal, name: &str) -> Self {
        let text = terminal.read(name);
        let (notes, table): (Vec<&str>, Vec<&str>) = text.lines().partition(|l| l.starts_with('#'));
        let header = table[0].split(',').map(str::to_owned).collect();
        let row = |line: &&str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let notes = notes.into_iter().flat_map(|note| [note, "\n"]).collect();
        Self { notes, header, rows: table[1..].iter().map(row).collect() }
    }

    pub(crate) fn column(&self, name: &str) -> Vec<f64> {
        let place = self.place(name);
        self.rows.iter().map(|row| row[place]).collect()
    }

    /// As real arms are logged: without accelerations, with friction and a little noise.
    pub(crate) fn recorded() -> Self {
        let mut table = Self::arm().without(&["ddq1", "ddq2"]);
        for joint in ["1", "2"] {
            let speed = table.place(&format!("dq{joint}"));
            table = table.with(&format!("tau{joint}"), |row, tau, values| {
                let dq = values[speed];
                tau + 0.6 * dq + 0.4 * (dq / 0.02).tanh() + 0.05 * noise(row)
            });
            table = table.with(&format!("q{joint}"), |row, q, _| q + 1e-4 * noise(row + 7));
        }
        table
    }

    pub(crate) fn place(&self, name: &str) -> usize {
        self.header.iter().position(|known| known == name).unwrap()
    }

    /// Another value in a column, of row, value and all values of the row.
    pub(crate) fn with(mut self, name: &str, value: impl Fn(usize, f64, &[f64]) -> f64) -> Self {
        let place = self.place(name);
        for (number, row) in self.rows.iter_mut().enumerate() {
            row[place] = value(number, row[place], row);
        }
        self
    }

    pub(crate) fn scaled(self, names: &[&str], factor: f64) -> Self {
        names.iter().fold(self, |table, name| table.with(name, |_, value, _| factor * value))
    }

    pub(crate) fn without(mut self, names: &[&str]) -> Self {
        for name in names {
            let place = self.place(name);
            self.header.remove(place);
            for row in &mut self.rows {
                row.remove(place);
            }
        }
        self
    }

    pub(crate) fn renamed(mut self, names: &[(&str, &str)]) -> Self {
        for (old, new) in names {
            let place = self.place(old);
            (*new).clone_into(&mut self.header[place]);
        }
        self
    }

    /// The same values once more, under another name.
    pub(crate) fn twice(mut self, name: &str, again: &str) -> Self {
        let place = self.place(name);
        self.header.push(again.to_owned());
        self.rows.iter_mut().for_each(|row| row.push(row[place]));
        self
    }

    pub(crate) fn text(&self) -> String {
        self.text_by(",")
    }

    pub(crate) fn text_by(&self, separator: &str) -> String {
        let row = |row: &Vec<f64>| {
            row.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(separator) + "\n"
        };
        let rows: String = self.rows.iter().map(row).collect();
        format!("{}{}\n{rows}", self.notes, self.header.join(separator))
    }

    pub(crate) fn inspected(&self) -> Said {
        let terminal = Terminal::holding("log.csv", &self.text());
        terminal.run("inspect log.csv --strict")
    }
}

/// Between -1 and 1, the same at each run.
pub(crate) fn noise(row: usize) -> f64 {
    let x = (row as f64 * 12.9898).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

/// Whether it was said with a warning, by a line with `--strict`.
pub(crate) fn assert_warns(said: &Said, words: &[&str]) {
    assert_eq!(said.code, 3, "{said:?}");
    assert_says(&said.stderr, words);
}

pub(crate) fn assert_tells(said: &Said, words: &[&str]) {
    assert!(matches!(said.code, 0 | 3), "{said:?}");
    assert_says(&said.stdout, words);
}
