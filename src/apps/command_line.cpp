// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "apps/command_line.hpp"

#include <malloc.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

volatile sig_atomic_t stop_requested = 0;

void requestStop(int) {
  stop_requested = 1;
}

void catchSignals() {
  struct sigaction action = {};
  action.sa_handler = requestStop;
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // the second signal has its ordinary effect
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

/// `camera_<i>/...`: parameters of one camera.
bool isCameraName(const std::string& argument) {
  return argument.rfind("camera_", 0) == 0;
}

/// Length of `name` where the argument reads `name=...`, else 0.
std::size_t paramNameLength(const std::string& argument) {
  const std::size_t length = argument.find('=');
  if (length == std::string::npos || length == 0) return 0;
  const bool may_have_slash = isCameraName(argument);
  const auto is_name = [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || (c == '/' && may_have_slash);
  };
  return std::all_of(argument.begin(), argument.begin() + static_cast<std::ptrdiff_t>(length), is_name) ? length : 0;
}

class Parser {
 public:
  Parser(int argc, const char* const* argv, const CommandSpec& spec)
      : arguments_(argv + std::min(argc, 1), argv + argc), spec_(spec) {
    line_.params = spec.defaults;
  }

  CommandLine parse() {
    line_.arguments = arguments_;
    bool only_positionals = false;
    for (; next_ < arguments_.size(); ++next_) {
      const std::string& argument = arguments_[next_];
      if (only_positionals) {
        line_.positionals.push_back(argument);
      } else if (argument == "--") {
        only_positionals = true;
      } else if (argument == "--help" || argument == "-h") {
        line_.help = true;
        return line_;
      } else if (argument == "--version") {
        line_.version = true;
        return line_;
      } else if (argument == "--quiet" || argument == "-q") {
        line_.quiet = true;
      } else if (argument == "--verbose" || argument == "-v") {
        line_.verbose = true;
      } else if (argument.size() > 1 && argument[0] == '-') {
        parseOption(argument);
      } else {
        parsePlain(argument);
      }
    }
    checkComplete();
    return line_;
  }

 private:
  void parseOption(const std::string& argument) {
    const std::size_t equals = argument.find('=');
    const std::string name = argument.substr(0, equals);
    const auto option = std::find_if(spec_.options.begin(), spec_.options.end(),
                                     [&](const OptionSpec& o) { return "--" + o.name == name; });
    require<UsageError>(option != spec_.options.end(), "unknown option ", name);
    require<UsageError>(!line_.has(option->name), "option ", name, " is given twice");
    if (option->value.empty()) {
      require<UsageError>(equals == std::string::npos, "option ", name, " takes no value");
      line_.options[option->name] = "true";
    } else if (equals != std::string::npos) {
      line_.options[option->name] = argument.substr(equals + 1);
    } else {
      require<UsageError>(next_ + 1 < arguments_.size(), "option ", name, " needs a value: ", name, " ", option->value);
      line_.options[option->name] = arguments_[++next_];
    }
  }

  void parsePlain(const std::string& argument) {
    const std::size_t length = spec_.takes_params ? paramNameLength(argument) : 0;
    if (length == 0) {
      line_.positionals.push_back(argument);
      return;
    }
    const std::string name = argument.substr(0, length);
    if (isOther(name)) {
      line_.others[name] = argument.substr(length + 1);
      return;
    }
    try {
      setParam(line_.params, name, argument.substr(length + 1));
    } catch (const std::invalid_argument& error) {
      throw UsageError(error.what());
    }
  }

  bool isOther(const std::string& name) const {
    const auto& others = spec_.other_params;
    const auto same = [&](const ParamText& param) { return param.name == name; };
    return !others.empty() && (isCameraName(name) || std::any_of(others.begin(), others.end(), same));
  }

  void checkComplete() {
    require<UsageError>(line_.positionals.size() >= spec_.min_positionals, "too few arguments; expected ",
                        spec_.positionals);
    require<UsageError>(line_.positionals.size() <= spec_.max_positionals, "unexpected argument ",
                        line_.positionals.empty() ? "" : line_.positionals.back(), "; expected ",
                        spec_.positionals.empty() ? "options only" : spec_.positionals);
    for (const OptionSpec& option : spec_.options) {
      require<UsageError>(!option.required || line_.has(option.name), "--", option.name, " ", option.value,
                          " is missing (", option.help, ")");
    }
    try {
      if (spec_.takes_params) line_.params.check();
    } catch (const std::invalid_argument& error) {
      throw UsageError(error.what());
    }
  }

  std::vector<std::string> arguments_;
  const CommandSpec& spec_;
  std::size_t next_ = 0;
  CommandLine line_;
};

void printRow(std::ostream& out, const std::string& left, const std::string& help) {
  out << "  " << std::left << std::setw(30) << left << ' ' << help << '\n';
}

/// Writes progress and log lines to stderr without mixing them.
class Terminal {
 public:
  void setQuiet(bool quiet) { is_quiet_ = quiet; }

  void show(const Progress& progress) {
    if (is_quiet_) return;
    const auto now = std::chrono::steady_clock::now();
    const bool finished = progress.total > 0 && progress.done >= progress.total;
    const std::size_t tenth = progress.total > 0 ? 10 * progress.done / progress.total : 0;
    // Where nothing is rewritten, a line every tenth, or now and then where nobody knows how much it is.
    const bool is_due = rewrites_            ? now - last_ >= std::chrono::milliseconds(100)
                        : progress.total > 0 ? tenth > tenth_
                                             : now - last_ >= std::chrono::seconds(5);
    if (progress.stage == stage_ && !finished && !is_due) return;
    stage_ = progress.stage;
    last_ = now;
    tenth_ = tenth;
    const std::string text = describeProgress(progress, rewrites_);
    if (!rewrites_) {
      if (text != line_) std::cerr << text << '\n' << std::flush;
      line_ = text;
      return;
    }
    clearLine();
    std::cerr << text << std::flush;
    open_ = true;
    if (finished) endLine();
  }

  void log(LogLevel level, const std::string& text) {
    if (is_quiet_ && level == LogLevel::kInfo) return;
    if (open_) clearLine();
    open_ = false;
    const char* prefix = level == LogLevel::kError ? "error: " : level == LogLevel::kWarning ? "warning: " : "";
    std::cerr << prefix << text << '\n' << std::flush;
  }

  void endLine() {
    if (open_) std::cerr << '\n' << std::flush;
    open_ = false;
  }

 private:
  static void clearLine() { std::cerr << "\r\033[K"; }

  const bool rewrites_ = isatty(STDERR_FILENO) != 0;
  bool open_ = false, is_quiet_ = false;
  std::size_t tenth_ = 0;
  std::string stage_, line_;
  std::chrono::steady_clock::time_point last_{};
};

Callbacks callbacksOf(const std::shared_ptr<Terminal>& terminal) {
  Callbacks callbacks;
  callbacks.progress = [terminal](const Progress& progress) { terminal->show(progress); };
  callbacks.log = [terminal](LogLevel level, const std::string& text) { terminal->log(level, text); };
  callbacks.cancelled = [] { return stop_requested != 0; };
  return callbacks;
}

/// Chunk after chunk takes and gives back hundreds of megabytes; fresh pages of the system cost a fifth of the time.
void keepMemory() {
  ::mallopt(M_MMAP_THRESHOLD, 1 << 30);
  ::mallopt(M_TRIM_THRESHOLD, 1 << 30);
}

}  // namespace

std::string CommandLine::option(const std::string& name, const std::string& otherwise) const {
  const auto found = options.find(name);
  return found == options.end() ? otherwise : found->second;
}

CommandLine parseCommandLine(int argc, const char* const* argv, const CommandSpec& spec) {
  return Parser(argc, argv, spec).parse();
}

std::string helpText(const CommandSpec& spec) {
  std::ostringstream out;
  out << "Usage: " << spec.program << (spec.positionals.empty() ? "" : " ") << spec.positionals;
  for (const OptionSpec& option : spec.options) {
    const std::string text = "--" + option.name + (option.value.empty() ? "" : " " + option.value);
    out << ' ' << (option.required ? text : "[" + text + "]");
  }
  out << (spec.takes_params ? " [name=value ...]" : "") << "\n\n" << spec.summary << "\n\nOptions:\n";
  for (const OptionSpec& option : spec.options) printRow(out, "--" + option.name + " " + option.value, option.help);
  printRow(out, "-q, --quiet", "warnings and errors only");
  printRow(out, "-v, --verbose", "also what each stage took; a report names files with their folders");
  printRow(out, "--help", "this text");
  printRow(out, "--version", "the version of the package");
  if (spec.takes_params) {
    const auto print = [&](const ParamText& param) { printRow(out, param.name + "=" + param.value, param.help); };
    const std::vector<ParamText> params = describeParams(spec.defaults);
    out << "\nParameters that matter most, with their defaults (the same names as the node's):\n";
    std::for_each(params.begin(), params.begin() + kNumMainParams, print);
    out << "\nFurther parameters:\n";
    std::for_each(params.begin() + kNumMainParams, params.end(), print);
    std::for_each(spec.other_params.begin(), spec.other_params.end(), print);
  }
  out << "\nExit codes: 0 done, 1 failed, 2 bad command line, 3 nothing or under 1 % coloured, or not rightly, 4 "
         "--fail-if holds, 130 cancelled by "
         "Ctrl-C.\n";
  return out.str();
}

const char* versionText() {
  return "cloud_colorizer " CLOUD_COLORIZER_VERSION;
}

std::string describeProgress(const Progress& progress, bool with_bar) {
  std::ostringstream out;
  out << progress.stage;
  if (progress.total > 0) {
    constexpr std::size_t kBarWidth = 20;
    const double percent = 100.0 * static_cast<double>(progress.done) / static_cast<double>(progress.total);
    const std::size_t filled = std::min(kBarWidth, kBarWidth * progress.done / progress.total);
    if (with_bar) out << " [" << std::string(filled, '#') << std::string(kBarWidth - filled, '-') << ']';
    out << ' ' << std::fixed << std::setprecision(0) << std::floor(percent) << " % (" << progress.done << " of "
        << progress.total << ')';
  } else if (progress.done > 0) {
    out << ' ' << progress.done;
  }
  if (progress.points_per_second > 0) {
    out << ", " << std::fixed << std::setprecision(0) << progress.points_per_second << " points/s";
  }
  if (progress.seconds_left >= 0) {
    out << ", " << std::fixed << std::setprecision(0) << std::ceil(progress.seconds_left) << " s left";
  }
  return out.str();
}

Callbacks terminalCallbacks() {
  catchSignals();
  return callbacksOf(std::make_shared<Terminal>());
}

int runMain(int argc, const char* const* argv, const CommandSpec& spec,
            const std::function<void(const CommandLine&, const Callbacks&)>& body) {
  keepMemory();
  const auto terminal = std::make_shared<Terminal>();
  try {
    const CommandLine line = parseCommandLine(argc, argv, spec);
    if (line.help) {
      std::cout << helpText(spec) << std::flush;
      return 0;
    }
    if (line.version) {
      std::cout << versionText() << std::endl;
      return 0;
    }
    catchSignals();
    terminal->setQuiet(line.quiet);
    body(line, callbacksOf(terminal));
    terminal->endLine();
    return 0;
  } catch (const UsageError& error) {
    terminal->log(LogLevel::kError, error.what());
    std::cerr << "Try: " << spec.program << " --help\n";
    return 2;
  } catch (const Cancelled&) {
    terminal->log(LogLevel::kError, "cancelled");
    return 130;
  } catch (const NothingColored& error) {
    terminal->log(LogLevel::kError, error.what());
    return 3;
  } catch (const ConditionHolds& error) {
    terminal->log(LogLevel::kError, error.what());
    return 4;
  } catch (const std::exception& error) {
    terminal->log(LogLevel::kError, error.what());
    return 1;
  }
}

}  // namespace cloud_colorizer
