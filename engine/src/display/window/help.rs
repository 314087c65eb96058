//! The table of keys as sheets over the picture: in as many columns, as small, and on as many pages as the window demands.

use super::keys::{GROUPS, Row};
use crate::display::sheet::{Corner, Sheet, capacity, fonts, ink};

/// Characters between columns.
const GAP: usize = 3;

/// A page of the help for a window of a size, from 0; none behind the last.
pub(super) fn page(window: [usize; 2], page: usize) -> Option<Sheet> {
    let longest = |of: fn(&Row) -> &str| rows().map(|row| of(row).len()).max().unwrap_or(0);
    let keys = longest(|row| row.keys) + 2;
    let width = keys + longest(|row| row.what);
    let all = fonts().map(|font| {
        let [characters, lines] = capacity(&font, window);
        // The last line says that there is another page.
        let columns = columns(lines.saturating_sub(1).max(2));
        let each = ((characters + GAP) / (width + GAP)).max(1);
        (font, characters >= width, columns, each)
    });
    let pages = |columns: &[Vec<Line>], each: usize| columns.len().div_ceil(each);
    // Rather several pages than the smallest font.
    let whole = all[..2].iter().find(|(_, fits, columns, each)| *fits && pages(columns, *each) == 1);
    let chosen = whole.or_else(|| all.iter().find(|(_, fits, ..)| *fits)).unwrap_or(&all[2]);
    let (font, _, all, each) = chosen;
    let (each, pages) = (*each, pages(all, *each));
    let columns = all.chunks(each).nth(page)?;
    let lines = columns.iter().map(Vec::len).max().unwrap_or(0);
    let mut sheet = Sheet::of_characters([columns.len() * (width + GAP) - GAP, lines + 1], *font, Corner::UpperLeft);
    for (i, column) in columns.iter().enumerate() {
        let left = i * (width + GAP);
        for (line, entry) in column.iter().enumerate() {
            match entry {
                Line::Heading(text) => sheet.write_at(ink::HEADING, [left, line], text),
                Line::Row(row) => {
                    sheet.write_at(ink::KEY, [left, line], row.keys);
                    sheet.write_at(ink::TEXT, [left + keys, line], row.what);
                }
                Line::Empty => {}
            }
        }
    }
    let more = if page + 1 < pages { format!("h: page {} of {pages}", page + 2) } else { "h: hide".to_owned() };
    sheet.write_at(ink::HEADING, [0, lines], &more);
    Some(sheet)
}

#[derive(Clone, Copy)]
enum Line {
    Heading(&'static str),
    Row(&'static Row),
    Empty,
}

fn rows() -> impl Iterator<Item = &'static Row> {
    GROUPS.iter().flat_map(|(_, rows)| rows.iter())
}

/// The table in columns of at most so many lines: groups stay together where they can.
fn columns(most: usize) -> Vec<Vec<Line>> {
    let mut columns: Vec<Vec<Line>> = vec![Vec::new()];
    for (heading, rows) in GROUPS {
        let last = columns.last().map_or(0, Vec::len);
        if last > 0 && last + 2 + rows.len() > most {
            columns.push(Vec::new());
        }
        let mut put = |line: Line| {
            if columns.last().is_none_or(|column| column.len() >= most) {
                columns.push(Vec::new());
            }
            if let Some(column) =
                columns.last_mut().filter(|column| !(column.is_empty() && matches!(line, Line::Empty)))
            {
                column.push(line);
            }
        };
        put(Line::Empty);
        put(Line::Heading(heading));
        rows.iter().for_each(|row| put(Line::Row(row)));
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_row_is_cut_off() {
        for most in [2, 5, 9, 20, 100] {
            let columns = columns(most);
            assert!(columns.iter().all(|column| !column.is_empty() && column.len() <= most));
            let found = columns.iter().flatten().filter(|line| matches!(line, Line::Row(_))).count();
            assert_eq!(found, rows().count());
        }
        for window in [[320, 240], [640, 480], [1024, 768], [1920, 1080], [300, 1000], [10, 10]] {
            let pages: Vec<Sheet> = (0..).map_while(|number| page(window, number)).collect();
            assert!(!pages.is_empty());
            if window[0] >= 320 {
                assert!(pages.iter().all(|page| page.fits(window)), "{window:?}");
            }
            assert!(window[0] < 1024 || pages.len() == 1, "{window:?}: {} pages", pages.len());
        }
    }
}
