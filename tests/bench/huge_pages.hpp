#pragma once

namespace voxatlas::bench {

/// Starts this program anew with glibc's heap on huge pages, once: call it first in main().
///
/// Why:    a map of some hundred megabytes, walked at random, measures the processor's page tables
///         otherwise: OctoMap carves about a quarter faster so, and the same scans give more even
///         figures. Both sides of a ratio get them.
/// Errors: none; where the kernel gives no huge pages, the heap has small ones.
void put_heap_on_huge_pages(char** argv);

}  // namespace voxatlas::bench
