//! Measured complex indices of refraction of metals, eta + i k.
//!
//! Each value is the published table interpolated linearly at three wavelengths, 630 nm for red,
//! 532 nm for green and 465 nm for blue, close to where Rec. 709's primaries look pure. That is three
//! lines of a spectrum, not an integral over it: hues are right, the last few percent are not.
//!
//! Sources: P. B. Johnson and R. W. Christy, "Optical constants of the noble metals", Phys. Rev. B 6
//! (1972); the same, "Optical constants of transition metals: Ti, V, Cr, Mn, Fe, Co, Ni, and Pd",
//! Phys. Rev. B 9 (1974); J. H. Weaver, C. G. Olson and D. W. Lynch, "Optical properties of crystalline
//! tungsten", Phys. Rev. B 12 (1975); T. Inagaki, E. T. Arakawa and M. W. Williams, "Optical properties
//! of liquid mercury", Phys. Rev. B 23 (1981); A. D. Rakić, "Algorithm for the determination of
//! intrinsic optical constants of metal films: application to aluminum", Appl. Opt. 34 (1995). All as
//! collected in the public-domain database of refractiveindex.info (M. N. Polyanskiy).

/// A metal's index at red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// Chemical symbol.
    pub symbol: &'static str,
    /// Real part of the index relative to vacuum.
    pub eta: [f32; 3],
    /// Imaginary part, the extinction coefficient.
    pub k: [f32; 3],
    /// Author and year of the measurement; titles stand above.
    pub source: &'static str,
}

/// All metals known by name.
#[allow(
    clippy::approx_constant,
    reason = "tungsten's green extinction happens to be e"
)]
pub const METALS: [Metal; 12] = [
    Metal {
        symbol: "Ag",
        eta: [0.057, 0.054, 0.047],
        k: [4.254, 3.429, 2.803],
        source: "Johnson and Christy 1972",
    },
    Metal {
        symbol: "Al",
        eta: [1.430, 0.939, 0.686],
        k: [7.508, 6.420, 5.635],
        source: "Rakić 1995",
    },
    Metal {
        symbol: "Au",
        eta: [0.188, 0.544, 1.332],
        k: [3.403, 2.231, 1.869],
        source: "Johnson and Christy 1972",
    },
    Metal {
        symbol: "Co",
        eta: [2.209, 2.001, 1.789],
        k: [4.160, 3.735, 3.371],
        source: "Johnson and Christy 1974",
    },
    Metal {
        symbol: "Cr",
        eta: [3.145, 3.034, 2.456],
        k: [3.312, 3.330, 3.210],
        source: "Johnson and Christy 1974",
    },
    Metal {
        symbol: "Cu",
        eta: [0.275, 1.116, 1.247],
        k: [3.373, 2.596, 2.456],
        source: "Johnson and Christy 1972",
    },
    Metal {
        symbol: "Fe",
        eta: [2.892, 2.895, 2.646],
        k: [3.065, 2.918, 2.805],
        source: "Johnson and Christy 1974",
    },
    Metal {
        symbol: "Hg",
        eta: [1.965, 1.461, 1.131],
        k: [5.213, 4.519, 3.990],
        source: "Inagaki, Arakawa and Williams 1981",
    },
    Metal {
        symbol: "Ni",
        eta: [1.990, 1.877, 1.765],
        k: [4.094, 3.495, 3.048],
        source: "Johnson and Christy 1974",
    },
    Metal {
        symbol: "Pd",
        eta: [1.765, 1.598, 1.445],
        k: [4.275, 3.743, 3.351],
        source: "Johnson and Christy 1974",
    },
    Metal {
        symbol: "Ti",
        eta: [2.698, 2.479, 2.305],
        k: [3.757, 3.351, 3.082],
        source: "Johnson and Christy 1974",
    },
    Metal {
        symbol: "W",
        eta: [3.617, 3.495, 3.325],
        k: [2.910, 2.718, 2.574],
        source: "Weaver, Olson and Lynch 1975",
    },
];

/// The metal with this chemical symbol.
pub fn metal(symbol: &str) -> Option<&'static Metal> {
    METALS.iter().find(|metal| metal.symbol == symbol)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reflectance at normal incidence, ((eta - 1)^2 + k^2) / ((eta + 1)^2 + k^2).
    fn reflectance(metal: &Metal) -> [f32; 3] {
        std::array::from_fn(|i| {
            let (eta, k2) = (metal.eta[i], metal.k[i] * metal.k[i]);
            ((eta - 1.0).powi(2) + k2) / ((eta + 1.0).powi(2) + k2)
        })
    }

    #[test]
    fn colours_are_those_one_sees() {
        let of = |symbol| reflectance(metal(symbol).expect("listed"));
        let (au, cu, ag, al) = (of("Au"), of("Cu"), of("Ag"), of("Al"));
        assert!(
            au[0] > 0.9 && au[1] < 0.8 && au[2] < 0.5,
            "gold is yellow: {au:?}"
        );
        assert!(
            cu[0] > 0.9 && cu[1] < 0.7 && cu[2] < 0.6,
            "copper is red: {cu:?}"
        );
        assert!(ag.iter().all(|&r| r > 0.95), "silver is white: {ag:?}");
        assert!(al.iter().all(|&r| (0.88..0.94).contains(&r)), "{al:?}");
        for symbol in ["Fe", "Cr", "W", "Ti"] {
            assert!(
                of(symbol).iter().all(|&r| (0.4..0.7).contains(&r)),
                "{symbol} is grey"
            );
        }
    }

    #[test]
    fn symbols_are_unique() {
        for (i, a) in METALS.iter().enumerate() {
            assert_eq!(metal(a.symbol), Some(a));
            assert!(METALS[i + 1..].iter().all(|b| b.symbol != a.symbol));
        }
        assert_eq!(metal("unobtainium"), None);
    }
}
