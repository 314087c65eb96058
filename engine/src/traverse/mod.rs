//! Image traversers.
