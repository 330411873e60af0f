// Lets the n-th call that changes or opens a file below a folder fail, or kills the process there.
// Preloaded into a child process; see faults.py.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

static char folder[4096];
static long count, chosen;
static int error_number;  // 0 = kill
static const char* failed = "";

void fault_arm(const char* below, long number, int error) {
  snprintf(folder, sizeof folder, "%s", below);
  count = 0, chosen = number, error_number = error, failed = "";
}
void fault_disarm(void) { folder[0] = 0; }
const char* fault_failed(void) { return failed; }

static int is_below(const char* path) {
  return folder[0] && path && strncmp(path, folder, strlen(folder)) == 0;
}
static int is_open_below(int descriptor) {
  char link[64], path[4096];
  if (!folder[0]) return 0;
  snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length < 0) return 0;
  path[length] = 0;
  return is_below(path);
}
static int fails(int concerns, const char* call) {
  if (!concerns || ++count != chosen) return 0;
  failed = call;
  if (!error_number) kill(getpid(), SIGKILL);
  errno = error_number;
  return 1;
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))
#define PATH_CALL(name, arguments, names, path) \
  int name arguments { return fails(is_below(path), #name) ? -1 : REAL(name) names; }
#define FILE_CALL(name, arguments, names) \
  int name arguments { return fails(is_open_below(fd), #name) ? -1 : REAL(name) names; }

PATH_CALL(rename, (const char* from, const char* to), (from, to), to)
PATH_CALL(link, (const char* from, const char* to), (from, to), to)
PATH_CALL(unlink, (const char* path), (path), path)
PATH_CALL(mkdir, (const char* path, mode_t mode), (path, mode), path)
PATH_CALL(rmdir, (const char* path), (path), path)
FILE_CALL(fsync, (int fd), (fd))
FILE_CALL(fdatasync, (int fd), (fd))
FILE_CALL(fchmod, (int fd, mode_t mode), (fd, mode))
FILE_CALL(ftruncate, (int fd, off_t size), (fd, size))
FILE_CALL(ftruncate64, (int fd, off64_t size), (fd, size))

int close(int fd) {  // the descriptor is gone, whatever it says
  const int is_failing = fails(is_open_below(fd), "close");
  const int result = REAL(close)(fd);
  if (is_failing) errno = error_number;
  return is_failing ? -1 : result;
}

// A full disk takes a part first; a killed process has written a part.
#define WRITE_CALL(name, arguments, half)                              \
  ssize_t name arguments {                                             \
    const int concerns = is_open_below(fd);                            \
    if (concerns && count + 1 == chosen && size > 1) half;             \
    if (fails(concerns, #name)) return -1;
WRITE_CALL(write, (int fd, const void* data, size_t size),
           (void)!REAL(write)(fd, data, error_number ? 0 : size / 2))
  return REAL(write)(fd, data, size);
}
WRITE_CALL(pwrite64, (int fd, const void* data, size_t size, off64_t at),
           (void)!REAL(pwrite64)(fd, data, error_number ? 0 : size / 2, at))
  return REAL(pwrite64)(fd, data, size, at);
}
ssize_t writev(int fd, const struct iovec* parts, int number) {
  return fails(is_open_below(fd), "writev") ? -1 : REAL(writev)(fd, parts, number);
}

#define OPEN_CALL(name)                                                             \
  int name(const char* path, int flags, ...) {                                      \
    va_list rest;                                                                   \
    va_start(rest, flags);                                                          \
    const mode_t mode = va_arg(rest, mode_t);                                       \
    va_end(rest);                                                                   \
    if (fails(is_below(path), flags & O_CREAT ? "create" : "open")) return -1;      \
    return REAL(name)(path, flags, mode);                                           \
  }
OPEN_CALL(open)
OPEN_CALL(open64)
