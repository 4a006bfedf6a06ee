// What a program that links vox::allocator tells jemalloc. It takes the place of the C library's
// malloc in the whole process, RocksDB's included.

/// Read by jemalloc itself, before main. Few threads allocate here, so two arenas do; and what was
/// freed goes back to the system soon, as a tile store is judged by what is resident.
extern "C" {
extern const char* malloc_conf;
const char* malloc_conf = "narenas:2,dirty_decay_ms:250,muzzy_decay_ms:0";
}
