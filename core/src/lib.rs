//! Ray packets, kernels, traversal.
#![no_std]
