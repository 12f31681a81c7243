// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive/parallel_drives.hpp"

#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

namespace tandem {
namespace {

constexpr unsigned kMaxSeeds = 100000;
constexpr std::size_t kMaxWorkers = 256;

// Memory shared with the workers: the next job, and the job of each worker.
struct Board {
  std::atomic<std::size_t> next{0};
  std::atomic<std::size_t> at[kMaxWorkers]{};
};

class SharedBoard {
 public:
  SharedBoard() {
    void* memory =
        mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED)
      throw std::runtime_error("cannot share memory with the worker processes");
    board_ = new (memory) Board;
  }
  ~SharedBoard() { munmap(board_, sizeof(Board)); }
  SharedBoard(const SharedBoard&) = delete;
  SharedBoard& operator=(const SharedBoard&) = delete;
  Board* operator->() const { return board_; }

 private:
  Board* board_;
};

void send(int pipe, const std::string& line) {
  for (std::size_t sent = 0; sent < line.size();) {
    const ssize_t n = write(pipe, line.data() + sent, line.size() - sent);
    if (n < 0 && errno != EINTR) std::_Exit(1);
    if (n > 0) sent += static_cast<std::size_t>(n);
  }
}

// Writes one line of JSON per job: [index, result], or [index, null, error].
[[noreturn]] void serve(std::size_t count, const SharedBoard& board, std::size_t worker,
                        const std::function<nlohmann::json(std::size_t)>& work, int pipe) {
  for (std::size_t i = board->next++; i < count; i = board->next++) {
    board->at[worker] = i;
    try {
      send(pipe, nlohmann::json::array({i, work(i)}).dump() + "\n");
    } catch (const std::exception& error) {
      send(pipe, nlohmann::json::array({i, nullptr, error.what()}).dump() + "\n");
    }
  }
  std::fflush(nullptr);
  std::_Exit(0);
}

struct Worker {
  pid_t pid;
  int pipe;
  std::string unread{};
};

class Workers {
 public:
  using Done = std::function<void(std::size_t, const nlohmann::json&)>;

  Workers(std::size_t count, unsigned workers,
          const std::function<nlohmann::json(std::size_t)>& work) {
    std::fflush(nullptr);
    for (std::size_t w = 0; w < std::min<std::size_t>({workers, count, kMaxWorkers}); ++w)
      start(count, w, work);
  }
  ~Workers() {  // workers are left only after an exception
    for (const Worker& worker : workers_) kill(worker.pid, SIGKILL);
    for (const Worker& worker : workers_) waitpid(worker.pid, nullptr, 0), close(worker.pipe);
  }
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  void collect(const Done& done) {
    std::vector<std::size_t> numbers;
    for (std::size_t w = 0; w < workers_.size(); ++w) numbers.push_back(w);
    while (!workers_.empty()) {
      std::vector<pollfd> waiting;
      for (const Worker& worker : workers_) waiting.push_back({worker.pipe, POLLIN, 0});
      if (poll(waiting.data(), waiting.size(), -1) < 0) continue;  // interrupted by a signal
      for (std::size_t w = workers_.size(); w-- > 0;) {
        if (waiting[w].revents == 0 || read_from(workers_[w], done)) continue;
        bury(workers_[w], numbers[w]);
        workers_.erase(workers_.begin() + static_cast<std::ptrdiff_t>(w));
        numbers.erase(numbers.begin() + static_cast<std::ptrdiff_t>(w));
      }
    }
  }

  // The number of failed jobs, and the error of the first.
  [[nodiscard]] std::size_t failed() const { return failed_; }
  [[nodiscard]] const std::string& trouble() const { return trouble_; }

 private:
  void start(std::size_t count, std::size_t w,
             const std::function<nlohmann::json(std::size_t)>& work) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("cannot create a pipe to a worker process");
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) std::_Exit(1);
      close(ends[0]);
      serve(count, board_, w, work, ends[1]);
    }
    close(ends[1]);
    if (child < 0) close(ends[0]);
    if (child < 0) throw std::runtime_error("cannot start a worker process");
    workers_.push_back({child, ends[0]});
  }

  // Returns false at the end of the worker's output.
  bool read_from(Worker& worker, const Done& done) {
    char bytes[65536];
    const ssize_t n = read(worker.pipe, bytes, sizeof bytes);
    if (n < 0) return errno == EINTR;
    if (n == 0) return false;
    worker.unread.append(bytes, static_cast<std::size_t>(n));
    std::size_t begin = 0;
    for (auto end = worker.unread.find('\n'); end != std::string::npos;
         begin = end + 1, end = worker.unread.find('\n', begin))
      take(nlohmann::json::parse(worker.unread.begin() + static_cast<std::ptrdiff_t>(begin),
                                 worker.unread.begin() + static_cast<std::ptrdiff_t>(end)),
           done);
    worker.unread.erase(0, begin);
    return true;
  }

  void take(const nlohmann::json& line, const Done& done) {
    if (line.size() == 2) return done(line[0], line[1]);
    fail(line[2].get<std::string>());
  }

  void bury(const Worker& worker, std::size_t number) {
    int status = 0;
    waitpid(worker.pid, &status, 0);
    close(worker.pipe);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
    fail("the process of drive number " + std::to_string(board_->at[number] + 1) + " died" +
         (WIFSIGNALED(status) ? " from signal " + std::to_string(WTERMSIG(status)) : ""));
  }

  void fail(const std::string& why) {
    if (failed_++ == 0) trouble_ = why;
  }

  SharedBoard board_;
  std::vector<Worker> workers_;
  std::size_t failed_ = 0;
  std::string trouble_;
};

}  // namespace

SeedRange seed_range(const std::string& option, const std::string& text) {
  const std::string range = text.find('-') == std::string::npos ? "1-" + text : text;
  unsigned first = 0, last = 0;
  char rest = '\0';
  if (std::sscanf(range.c_str(), "%u-%u%c", &first, &last, &rest) != 2 || first == 0 ||
      last < first || last - first >= kMaxSeeds)
    throw std::invalid_argument(option + " " + text + ": expected N or A-B with 1 <= A <= B, " +
                                std::to_string(kMaxSeeds) + " at most");
  return {first, last};
}

void work_side_by_side(std::size_t count, unsigned workers,
                       const std::function<nlohmann::json(std::size_t)>& work,
                       const std::function<void(std::size_t, const nlohmann::json&)>& done) {
  Workers all{count, workers, work};
  std::size_t finished = 0;
  all.collect([&](std::size_t i, const nlohmann::json& result) {
    ++finished;
    done(i, result);
  });
  if (all.failed() > 0)
    throw std::runtime_error(std::to_string(count - finished) + " of " + std::to_string(count) +
                             " drives failed; the first error: " + all.trouble());
}

std::vector<DriveResult> run_side_by_side(const std::vector<DriveJob>& jobs, unsigned workers,
                                          const std::function<DriveResult(const DriveJob&)>& drive,
                                          const std::function<void()>& finished) {
  std::vector<DriveResult> results(jobs.size());
  work_side_by_side(
      jobs.size(), workers, [&](std::size_t i) { return nlohmann::json(drive(jobs[i])); },
      [&](std::size_t i, const nlohmann::json& result) {
        result.get_to(results[i]);
        finished();
      });
  return results;
}

}  // namespace tandem
