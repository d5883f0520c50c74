//! The publications that methods come from, in BibTeX.

/// A publication.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    bibtex: &'static str,
}

impl Source {
    /// The entry in BibTeX.
    pub const fn bibtex(&self) -> &'static str {
        self.bibtex
    }

    /// The key of the entry.
    pub fn key(&self) -> &'static str {
        let key = self.bibtex.split(['{', ',']).nth(1);
        key.unwrap_or_default()
    }
}

/// The paper whose experiment afterbay repeats. All reservoirs are taken from it.
pub const KOBUS: Source = Source {
    bibtex: r"@unpublished{kobus,
  author = {Kobus, Artur},
  title = {Forced extension of {GNI} techniques to dissipative systems},
  note = {Manuscript, Uniwersytet w Bia{\l}ymstoku}
}",
};

pub(super) const VERLET: Source = Source {
    bibtex: r#"@article{verlet1967,
  author = {Verlet, L.},
  title = {Computer "Experiments" on Classical Fluids. {I}. Thermodynamical Properties of
           {Lennard-Jones} Molecules},
  journal = {Physical Review},
  volume = {159},
  number = {1},
  pages = {98--103},
  year = {1967},
  doi = {10.1103/PhysRev.159.98}
}"#,
};

pub(super) const HAIRER_LUBICH_WANNER_2003: Source = Source {
    bibtex: r#"@article{hairer2003,
  author = {Hairer, Ernst and Lubich, Christian and Wanner, Gerhard},
  title = {Geometric numerical integration illustrated by the {St{\"o}rmer--Verlet} method},
  journal = {Acta Numerica},
  volume = {12},
  pages = {399--450},
  year = {2003},
  doi = {10.1017/S0962492902000144}
}"#,
};

pub(super) const HAIRER_LUBICH_WANNER_2006: Source = Source {
    bibtex: r"@book{hairer2006,
  author = {Hairer, Ernst and Lubich, Christian and Wanner, Gerhard},
  title = {Geometric Numerical Integration: Structure-Preserving Algorithms for Ordinary
           Differential Equations},
  edition = {2},
  publisher = {Springer},
  year = {2006},
  doi = {10.1007/3-540-30666-8}
}",
};

pub(super) const KUTTA: Source = Source {
    bibtex: r#"@article{kutta1901,
  author = {Kutta, Wilhelm},
  title = {Beitrag zur n{\"a}herungsweisen {I}ntegration totaler {D}ifferentialgleichungen},
  journal = {Zeitschrift f{\"u}r Mathematik und Physik},
  volume = {46},
  pages = {435--453},
  year = {1901}
}"#,
};

pub(super) const HAIRER_NORSETT_WANNER: Source = Source {
    bibtex: r"@book{hairer1993,
  author = {Hairer, Ernst and N{\o}rsett, Syvert P. and Wanner, Gerhard},
  title = {Solving Ordinary Differential Equations {I}: Nonstiff Problems},
  edition = {2},
  series = {Springer Series in Computational Mathematics},
  volume = {8},
  publisher = {Springer},
  year = {1993},
  doi = {10.1007/978-3-540-78862-1}
}",
};

pub(super) const HAIRER_WANNER_1996: Source = Source {
    bibtex: r"@book{hairer1996,
  author = {Hairer, Ernst and Wanner, Gerhard},
  title = {Solving Ordinary Differential Equations {II}: Stiff and Differential-Algebraic
           Problems},
  edition = {2},
  series = {Springer Series in Computational Mathematics},
  volume = {14},
  publisher = {Springer},
  year = {1996},
  doi = {10.1007/978-3-642-05221-7}
}",
};

pub(super) const HAIRER_WANNER_1999: Source = Source {
    bibtex: r"@article{hairer1999,
  author = {Hairer, Ernst and Wanner, Gerhard},
  title = {Stiff differential equations solved by {Radau} methods},
  journal = {Journal of Computational and Applied Mathematics},
  volume = {111},
  number = {1--2},
  pages = {93--111},
  year = {1999},
  doi = {10.1016/S0377-0427(99)00134-X}
}",
};

pub(super) const KETCHESON: Source = Source {
    bibtex: r"@article{ketcheson2019,
  author = {Ketcheson, David I.},
  title = {Relaxation {Runge--Kutta} Methods: Conservation and Stability for Inner-Product Norms},
  journal = {SIAM Journal on Numerical Analysis},
  volume = {57},
  number = {6},
  pages = {2850--2870},
  year = {2019},
  doi = {10.1137/19M1263662}
}",
};

pub(super) const RANOCHA: Source = Source {
    bibtex: r"@article{ranocha2020,
  author = {Ranocha, Hendrik and Sayyari, Mohammed and Dalcin, Lisandro and Parsani, Matteo and
            Ketcheson, David I.},
  title = {Relaxation {Runge--Kutta} Methods: Fully Discrete Explicit Entropy-Stable Schemes for
           the Compressible {Euler} and {Navier--Stokes} Equations},
  journal = {SIAM Journal on Scientific Computing},
  volume = {42},
  number = {2},
  pages = {A612--A638},
  year = {2020},
  doi = {10.1137/19M1263480}
}",
};

pub(super) const GONZALEZ: Source = Source {
    bibtex: r"@article{gonzalez1996,
  author = {Gonzalez, O.},
  title = {Time integration and discrete {Hamiltonian} systems},
  journal = {Journal of Nonlinear Science},
  volume = {6},
  number = {5},
  pages = {449--467},
  year = {1996},
  doi = {10.1007/bf02440162}
}",
};

pub(super) const CIESLINSKI_RATKIEWICZ: Source = Source {
    bibtex: r"@misc{cieslinski2009,
  author = {Cie{\'s}li{\'n}ski, Jan L. and Ratkiewicz, Bogus{\l}aw},
  title = {How to improve the accuracy of the discrete gradient method in the one-dimensional
           case},
  year = {2009},
  eprint = {0901.1906},
  archiveprefix = {arXiv},
  note = {Published in Physical Review E 81 (2010) 016704}
}",
};

pub(super) const CIESLINSKI: Source = Source {
    bibtex: r"@misc{cieslinski2013,
  author = {Cie{\'s}li{\'n}ski, Jan L.},
  title = {Locally exact modifications of discrete gradient schemes},
  year = {2013},
  eprint = {1304.6533},
  archiveprefix = {arXiv}
}",
};

pub(super) const BRUGNANO: Source = Source {
    bibtex: r"@article{brugnano2010,
  author = {Brugnano, Luigi and Iavernaro, Felice and Trigiante, Donato},
  title = {{Hamiltonian} Boundary Value Methods (Energy Preserving Discrete Line Integral
           Methods)},
  journal = {Journal of Numerical Analysis, Industrial and Applied Mathematics},
  volume = {5},
  number = {1--2},
  pages = {17--37},
  year = {2010}
}",
};

pub(super) const HAIRER_2010: Source = Source {
    bibtex: r"@article{hairer2010,
  author = {Hairer, Ernst},
  title = {Energy-preserving variant of collocation methods},
  journal = {Journal of Numerical Analysis, Industrial and Applied Mathematics},
  volume = {5},
  pages = {73--84},
  year = {2010}
}",
};

pub(super) const BUTCHER: Source = Source {
    bibtex: r"@article{butcher1964,
  author = {Butcher, John C.},
  title = {Implicit {Runge--Kutta} processes},
  journal = {Mathematics of Computation},
  volume = {18},
  number = {85},
  pages = {50--64},
  year = {1964},
  doi = {10.1090/S0025-5718-1964-0159424-9}
}",
};

pub(super) const ITOH_ABE: Source = Source {
    bibtex: r"@article{itoh1988,
  author = {Itoh, T. and Abe, K.},
  title = {{Hamiltonian}-conserving discrete canonical equations based on variational difference
           quotients},
  journal = {Journal of Computational Physics},
  volume = {76},
  number = {1},
  pages = {85--102},
  year = {1988},
  doi = {10.1016/0021-9991(88)90132-5}
}",
};

pub(super) const SUZUKI: Source = Source {
    bibtex: r"@article{suzuki1990,
  author = {Suzuki, Masuo},
  title = {Fractal decomposition of exponential operators with applications to many-body theories
           and {Monte Carlo} simulations},
  journal = {Physics Letters A},
  volume = {146},
  number = {6},
  pages = {319--323},
  year = {1990},
  doi = {10.1016/0375-9601(90)90962-N}
}",
};

pub(super) const YOSHIDA: Source = Source {
    bibtex: r"@article{yoshida1990,
  author = {Yoshida, Haruo},
  title = {Construction of higher order symplectic integrators},
  journal = {Physics Letters A},
  volume = {150},
  number = {5--7},
  pages = {262--268},
  year = {1990},
  doi = {10.1016/0375-9601(90)90092-3}
}",
};

pub(super) const KAHAN_LI: Source = Source {
    bibtex: r"@article{kahan1997,
  author = {Kahan, William and Li, Ren-Cang},
  title = {Composition constants for raising the orders of unconventional schemes for ordinary
           differential equations},
  journal = {Mathematics of Computation},
  volume = {66},
  number = {219},
  pages = {1089--1099},
  year = {1997},
  doi = {10.1090/S0025-5718-97-00873-9}
}",
};

pub(super) const BLANES_MOAN: Source = Source {
    bibtex: r#"@article{blanes2002,
  author = {Blanes, S. and Moan, P. C.},
  title = {Practical symplectic partitioned {Runge--Kutta} and {Runge--Kutta--Nystr{\"o}m} methods},
  journal = {Journal of Computational and Applied Mathematics},
  volume = {142},
  number = {2},
  pages = {313--330},
  year = {2002},
  doi = {10.1016/S0377-0427(01)00492-7}
}"#,
};

pub(super) const VERNER: Source = Source {
    bibtex: r"@article{verner2010,
  author = {Verner, James H.},
  title = {Numerically optimal {Runge--Kutta} pairs with interpolants},
  journal = {Numerical Algorithms},
  volume = {53},
  number = {2--3},
  pages = {383--396},
  year = {2010},
  doi = {10.1007/s11075-009-9290-3}
}",
};
