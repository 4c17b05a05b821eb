#pragma once
// The built programs as a person runs them: in a folder, with words on a command line, judged by exit code, output,
// and the files that are left.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace airside {

namespace fs = std::filesystem;

struct Outcome {
  int code = -1;  ///< 128 + signal for a crash
  std::string out, err;
};

inline std::string text_of_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Runs `program` of the build (or another one, by its whole path) with `words` in `folder`; output goes by way of
/// files in `scratch`.
inline Outcome run_program(const std::string& program, std::vector<std::string> words, const fs::path& folder,
                           const fs::path& scratch, unsigned limit_s = 60) {
  words.insert(words.begin(), program.starts_with('/') ? program : std::string(AIRSIDE_BIN_DIR) + "/" + program);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const fs::path out = scratch / "out", err = scratch / "err";
  const pid_t child = fork();
  if (child == 0) {
    const int to_out = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const int to_err = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (to_out < 0 || to_err < 0 || dup2(to_out, STDOUT_FILENO) < 0 || dup2(to_err, STDERR_FILENO) < 0 ||
        chdir(folder.c_str()) != 0) {
      _exit(126);
    }
    alarm(limit_s);  // a program that hangs is killed, which is no exit code 1
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  int status = 0;
  waitpid(child, &status, 0);
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return {code, text_of_file(out), text_of_file(err)};
}

/// A folder of its own, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (fs::path(testing::TempDir()) / "airside_input_XXXXXX").string();
    path_ = mkdtemp(pattern.data()) == nullptr ? fs::path() : fs::path(pattern);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Every file and folder below, by relative name.
inline std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    names.insert(fs::relative(entry.path(), folder).string());
  }
  return names;
}

/// The four parts of a complaint that a program printed; empty where there is none.
struct Said {
  std::string place, found, expected, remedy;
};

/// From "airside: PLACE: found F; expected E; REMEDY", the first such line.
inline Said complaint_in(const std::string& text) {
  const std::size_t found = text.find(": found ");
  if (found == std::string::npos) return {};
  const std::size_t begin = text.rfind('\n', found) == std::string::npos ? 0 : text.rfind('\n', found) + 1;
  const std::size_t end = text.find('\n', found);
  // A parser's own words in FOUND may say "; expected " too, so the last one on the line counts.
  const std::size_t expected = text.rfind("; expected ", end);
  if (expected == std::string::npos || expected < found) return {};
  const std::size_t remedy = text.find("; ", expected + 11);
  if (remedy == std::string::npos || remedy > end) return {};
  return {text.substr(begin, found - begin), text.substr(found + 8, expected - found - 8),
          text.substr(expected + 11, remedy - expected - 11), text.substr(remedy + 2, end - remedy - 2)};
}

}  // namespace airside
