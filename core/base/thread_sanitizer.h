#pragma once

// ThreadSanitizer cannot see inside oneTBB, which Debian builds without it. Code whose threads come
// from there tells it the edges that matter; elsewhere these are nothing.
#if defined(RELUME_TSAN) || defined(__SANITIZE_THREAD__)
extern "C" void __tsan_acquire(void*);
extern "C" void __tsan_release(void*);
#else
static inline void __tsan_acquire(void*) {}
static inline void __tsan_release(void*) {}
#endif
