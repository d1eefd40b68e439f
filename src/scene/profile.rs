//! How a measured lamp spreads its light.

/// Luminous intensity over all directions: a table over the polar angle from the lamp's axis and the
/// azimuth about it. Rows are polar angles from 0 to pi, both ends included; the columns of a row are
/// azimuths from 0 on, one turn over all of them, and a single column is a lamp alike all around.
/// Linear between entries.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    pub rows: u32,
    pub columns: u32,
    /// Candela by rows, finite and not negative.
    pub candela: Vec<f32>,
}

impl Profile {
    /// Over all directions.
    pub fn mean(&self) -> f64 {
        let step = std::f64::consts::PI / f64::from(self.rows - 1);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (row, candela) in self.candela.chunks_exact(self.columns as usize).enumerate() {
            let weight = (row as f64 * step).sin();
            sum += weight * candela.iter().map(|&x| f64::from(x)).sum::<f64>();
            weights += weight * candela.len() as f64;
        }
        sum / weights
    }
}
