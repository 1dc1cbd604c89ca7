// Ends a program at its N-th call that changes a file, or lets that call and all after it find a full disk. Preloaded:
//
//     LAST_WRITE=12 LAST_WRITE_HOW=kill LD_PRELOAD=./last_write.so brdfc build ...
//
// Calls that change a file: opening one for writing, write and its like to a file, rename, unlink, mkdir, rmdir, link, truncate.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static atomic_long calls;

// Returns true if this call must fail for lack of space. 'grows' is 0 for calls that a full disk still allows.
static int is_last(int grows) {
    static long last = -1;
    static int kills;
    if (last < 0) {
        const char *number = getenv("LAST_WRITE"), *how = getenv("LAST_WRITE_HOW");
        last = number ? atol(number) : 0;
        kills = how && strcmp(how, "kill") == 0;
    }
    long call = atomic_fetch_add(&calls, 1) + 1;
    if (last == 0 || call < last) {
        return 0;
    }
    if (kills) {
        raise(SIGKILL);
    }
    if (!grows) {
        return 0;
    }
    errno = ENOSPC;
    return 1;
}

static int is_file(int fd) {
    struct stat found;
    return fstat(fd, &found) == 0 && S_ISREG(found.st_mode);
}

#define NEXT(name, type) ((type)dlsym(RTLD_NEXT, #name))

#define OPENS(name, parameters, arguments)                                   \
    int name parameters {                                                    \
        mode_t mode = 0;                                                     \
        if (flags & (O_CREAT | O_TMPFILE)) {                                 \
            va_list more;                                                    \
            va_start(more, flags);                                           \
            mode = va_arg(more, mode_t);                                     \
            va_end(more);                                                    \
        }                                                                    \
        if ((flags & O_ACCMODE) != O_RDONLY && is_last(flags & O_CREAT)) {   \
            return -1;                                                       \
        }                                                                    \
        return NEXT(name, int (*) parameters) arguments;                     \
    }

OPENS(open, (const char *path, int flags, ...), (path, flags, mode))
OPENS(open64, (const char *path, int flags, ...), (path, flags, mode))
OPENS(openat, (int folder, const char *path, int flags, ...), (folder, path, flags, mode))
OPENS(openat64, (int folder, const char *path, int flags, ...), (folder, path, flags, mode))

#define WRITES(name, parameters, arguments)                    \
    ssize_t name parameters {                                  \
        if (is_file(fd) && is_last(1)) {                       \
            return -1;                                         \
        }                                                      \
        return NEXT(name, ssize_t (*) parameters) arguments;   \
    }

WRITES(write, (int fd, const void *bytes, size_t count), (fd, bytes, count))
WRITES(writev, (int fd, const struct iovec *parts, int count), (fd, parts, count))
WRITES(pwrite64, (int fd, const void *bytes, size_t count, off64_t at), (fd, bytes, count, at))

#define CHANGES(name, grows, parameters, arguments)      \
    int name parameters {                                \
        if (is_last(grows)) {                            \
            return -1;                                   \
        }                                                \
        return NEXT(name, int (*) parameters) arguments; \
    }

CHANGES(rename, 0, (const char *from, const char *to), (from, to))
CHANGES(link, 1, (const char *from, const char *to), (from, to))
CHANGES(unlink, 0, (const char *path), (path))
CHANGES(unlinkat, 0, (int folder, const char *path, int flags), (folder, path, flags))
CHANGES(rmdir, 0, (const char *path), (path))
CHANGES(mkdir, 1, (const char *path, mode_t mode), (path, mode))
CHANGES(ftruncate64, 1, (int fd, off64_t length), (fd, length))
