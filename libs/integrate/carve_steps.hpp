#pragma once

#include <Eigen/Core>

#include "integrate/marks.hpp"

namespace voxatlas {

/// Carves a ray at depth 7 with vectors, eight slabs of a brick at a time.
///
/// Idea:   the axis with the longest way, `a`, cuts a ray into slabs of one voxel. Where the ray is
///         on the other two, u and v, when it crosses a slab's borders is a line, which eight lanes
///         follow in fixed point: 5 bits of voxels within two bricks, 27 of fraction, started anew
///         for each brick from 64 bits, so that the error stays below 2^-24 of a voxel. A slab has
///         three cells at most: (u0, v0), (u1, v1), and between them the one that the earlier of
///         the two crossings leads to. They are two rows of bits, for v0 and v1, each b0 = 1 << u0,
///         b1 = 1 << u1 or both, and eight slabs are the eight words of a brick's plane.
/// Exact:  where the line is within 2^-22 of a border at a slab's border, or u and v are crossed
///         within about 2^-20 of one another, rounding might decide. Then this refuses, before it
///         marks anything of that brick. Elsewhere no comparison of Walk's, whose t is right to
///         2^-51, can come out differently. About one ray in 5000 is refused, and all that run
///         along an axis.
/// Note:   Highway picks the instructions at run time (AVX2, AVX-512). Lanes hold whole numbers but
///         for the estimate of what comes first, whose margin covers its rounding.
/// Return: false where it refused, or the processor has no AVX2; marks it may have set by then are
///         right, but not all. Leaves marks in the planes of every axis.
bool carve_steps(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels,
                 Marks& misses);

}  // namespace voxatlas
