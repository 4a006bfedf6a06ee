// OSMesa 22.3 keeps some 200 bytes of a context's last framebuffer for ever: LeakSanitizer, where
// it runs, shall report our own leaks only.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa"; }
