#pragma once
// What `airside check` found: things in order, complaints and warnings, in the order in which they were looked at.

#include <algorithm>
#include <cstddef>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "hal/text/input_error.hpp"
#include "tools/cli/site/site_signals.hpp"

namespace airside::tools {

/// One thing that was looked at: in order with its key facts, or the complaint, with those beside it.
struct Finding {
  std::string what, file, facts;
  std::optional<hal::InputError> complaint;
  std::vector<hal::InputError> more{};
};

struct Warning {
  std::string what, file, text;
};

class Findings {
 public:
  /// Runs `look`, which returns the key facts, and remembers what came of it.
  template <class Look>
  void check(const std::string& what, const std::string& file, Look&& look) {
    try {
      add({what, file, look(), {}});
    } catch (const hal::InputError& e) {
      add({what, file, "", e});
    } catch (const std::exception& e) {
      add({what, file, "",
           hal::InputError(file, e.what(), "a readable " + what, "correct the file or its permissions")});
    }
  }
  /// Something that is in order and yet unlikely to be meant.
  void warn(const std::string& what, const std::string& file, std::string text) {
    warnings_.push_back({what, file, std::move(text)});
  }
  void refuse(const std::string& what, const std::string& file, const hal::InputError& e) { add({what, file, "", e}); }

  /// Runs `look`, which returns the key facts, or adds to the complaints that it is given.
  template <class Look>
  void check_all(const std::string& what, const std::string& file, Look&& look) {
    std::vector<hal::InputError> complaints;
    check(what, file, [&] {
      std::string facts = look(complaints);
      if (!complaints.empty()) throw hal::InputError(complaints.front());
      return facts;
    });
    if (complaints.size() > 1) all_.back().more.assign(complaints.begin() + 1, complaints.end());
  }

  /// Complaints, those beside a first one too.
  std::size_t complaints() const {
    std::size_t count = failed();
    for (const Finding& f : all_) count += f.more.size();
    return count;
  }
  std::size_t failed() const {
    return static_cast<std::size_t>(
        std::count_if(all_.begin(), all_.end(), [](const Finding& f) { return f.complaint.has_value(); }));
  }
  const std::vector<Finding>& all() const { return all_; }
  const std::vector<Warning>& warnings() const { return warnings_; }

  std::vector<LackingSignals> lacking;  ///< of the site

 private:
  void add(Finding f) { all_.push_back(std::move(f)); }
  std::vector<Finding> all_;
  std::vector<Warning> warnings_;
};

}  // namespace airside::tools
