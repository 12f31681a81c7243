// SPDX-License-Identifier: Apache-2.0
// To be preloaded: the system clock of one process is off by the nanoseconds (an int64_t) that the
// file TANDEM_CLOCK_OFFSET holds, as on another computer; the steady clock is not.
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static const volatile int64_t* offset;  // [ns]

__attribute__((constructor)) static void open_offset(void) {
  const char* path = getenv("TANDEM_CLOCK_OFFSET");
  const int file = path ? open(path, O_RDONLY) : -1;
  if (file < 0) return;
  void* memory = mmap(NULL, sizeof *offset, PROT_READ, MAP_SHARED, file, 0);
  close(file);
  if (memory != MAP_FAILED) offset = memory;
}

int clock_gettime(clockid_t id, struct timespec* time) {
  const long result = syscall(SYS_clock_gettime, id, time);
  if (result != 0 || id != CLOCK_REALTIME || !offset) return (int)result;
  const int64_t second = 1000000000, now = time->tv_sec * second + time->tv_nsec + *offset;
  time->tv_sec = now / second;
  time->tv_nsec = now % second;
  return 0;
}

time_t time(time_t* where) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (where) *where = now.tv_sec;
  return now.tv_sec;
}

int gettimeofday(struct timeval* restrict time, void* restrict zone) {
  (void)zone;
  struct timespec now;
  const int result = clock_gettime(CLOCK_REALTIME, &now);
  time->tv_sec = now.tv_sec;
  time->tv_usec = now.tv_nsec / 1000;
  return result;
}
