//! Places between two values of a list.

/// Place between two values of a list.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Index of the lower value.
    pub lower: usize,
    /// Share of the upper one.
    pub share: f64,
}

impl Place {
    /// Place from which a stretch moves lines to a bin.
    pub fn new(k: usize, stretch: f64) -> Self {
        Self::at(k as f64 / (1.0 + stretch))
    }

    /// Place of a value among rising ones by its logarithm, within the first and the last.
    pub fn among(values: &[f64], value: f64) -> Self {
        let last = values.len() - 1;
        let lower = values[..last].partition_point(|v| *v <= value).max(1) - 1;
        let share = (value / values[lower]).ln() / (values[lower + 1] / values[lower]).ln();
        if share < 1.0 { Self { lower, share: share.max(0.0) } } else { Self { lower: last, share: 0.0 } }
    }

    /// Place of an index with a fraction.
    pub fn at(place: f64) -> Self {
        let lower = place as usize;
        Self { lower, share: place - lower as f64 }
    }

    /// Value there.
    pub fn of(self, values: &[f64]) -> f64 {
        match values.get(self.lower..self.lower + 2) {
            Some(&[lower, upper]) => lower * (1.0 - self.share) + upper * self.share,
            _ => values.last().copied().unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_among_rising_values_is_by_its_logarithm() {
        let of = |value: f64| {
            let Place { lower, share } = Place::among(&[1.0, 3.0, 9.0], value);
            (lower, (1e6 * share).round() / 1e6)
        };
        assert_eq!([1.0, 3f64.sqrt(), 3.0, 9.0, 100.0].map(of), [(0, 0.0), (0, 0.5), (1, 0.0), (2, 0.0), (2, 0.0)]);
    }
}
