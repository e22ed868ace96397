// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/tool_main.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <initializer_list>
#include <iostream>
#include <sstream>
#include <vector>

#include <gflags/gflags.h>
#include <glog/logging.h>

#include "prism/base/error.h"
#include "prism/base/format.h"
#include "prism/base/version.h"
#include "prism_git_revision.h"

// gflags ends the program with status 1 on a bad flag; it lets tests replace the function it calls.
namespace GFLAGS_NAMESPACE {
extern GFLAGS_DLL_DECL void (*gflags_exitfunc)(int);
}

namespace prism {
namespace {

bool IsOwnFlag(const gflags::CommandLineFlagInfo& flag) {
  return flag.filename.find("tools/") != std::string::npos;
}

std::vector<gflags::CommandLineFlagInfo> OwnFlags() {
  std::vector<gflags::CommandLineFlagInfo> flags;
  gflags::GetAllFlags(&flags);
  flags.erase(
      std::remove_if(flags.begin(), flags.end(), [](const auto& f) { return !IsOwnFlag(f); }),
      flags.end());
  return flags;
}

// gflags writes 0.004 as 0.0040000000000000001.
std::string ShortestNumber(const std::string& value, const std::string& type) {
  if (type != "double") return value;
  const double number = std::strtod(value.c_str(), nullptr);
  char text[40];
  for (const int digits : {6, 9, 15}) {
    std::snprintf(text, sizeof(text), "%.*g", digits, number);
    if (std::strtod(text, nullptr) == number) return text;
  }
  return value;
}

void PrintHelp(const ToolDescription& description) {
  std::cout << description.name << ": " << description.summary << "\n\nUsage: " << description.name
            << " " << description.usage << "\n\nExample:\n  " << description.example
            << "\n\nFlags:\n";
  for (const auto& flag : OwnFlags()) {
    std::cout << "  --" << flag.name << "=" << ShortestNumber(flag.default_value, flag.type)
              << "  (" << flag.type << ")\n      " << flag.description << "\n";
  }
  std::cout << "  --flagfile=\n      A file of flags, one a line.\n  --version\n      Prints "
               "version and revision.\n";
}

bool HasArgument(int argc, char** argv, std::initializer_list<const char*> names) {
  return std::any_of(argv + 1, argv + argc, [&](const char* argument) {
    return std::any_of(names.begin(), names.end(), [&](const char* name) {
      return std::strcmp(argument, name) == 0;
    });
  });
}

// One line of a length people read, whatever a file had in it.
std::string OneLine(std::string text) {
  constexpr size_t kLongest = 1000, kPart = 490;
  if (text.size() > kLongest) {
    text.replace(kPart, text.size() - 2 * kPart, " ... ");
  }
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = '?';
  }
  return text;
}

ExitStatus ReportBadInput(const ToolDescription& description, const std::string& what) {
  std::cout.flush();
  std::cerr << description.name << ": " << OneLine(what) << std::endl;
  return kExitBadInput;
}

}  // namespace

std::string GitRevision() { return PRISM_GIT_REVISION; }

std::map<std::string, std::string> EffectiveOptions() {
  std::map<std::string, std::string> options;
  for (const auto& flag : OwnFlags()) {
    options[flag.name] = ShortestNumber(flag.current_value, flag.type);
  }
  return options;
}

void RequireFlag(const std::string& name, const std::string& value, const std::string& expected) {
  if (value.empty()) throw InputError("--" + name, "nothing", expected);
}

void RequireInRange(const std::string& name, double value, double min, double max) {
  if (value >= min && value <= max) return;
  throw InputError("--" + name, Format("%g", value), Format("%g to %g", min, max));
}

std::vector<std::string> SplitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  std::stringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) {
    if (!part.empty()) parts.push_back(part);
  }
  return parts;
}

int RunTool(const ToolDescription& description,
            int argc,
            char** argv,
            const std::function<ExitStatus()>& run) {
  if (HasArgument(argc, argv, {"--help", "-help", "-h"})) {
    PrintHelp(description);
    return kExitDone;
  }
  if (HasArgument(argc, argv, {"--version", "-version"})) {
    std::cout << description.name << " " << kVersion << " (" << GitRevision() << ")" << std::endl;
    return kExitDone;
  }
  GFLAGS_NAMESPACE::gflags_exitfunc = [](int status) {
    std::exit(status == 0 ? kExitDone : kExitBadInput);
  };
  FLAGS_logtostderr = true;
  google::InitGoogleLogging(argv[0]);
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  try {
    if (argc > 1) throw InputError("command line", "'" + std::string(argv[1]) + "'", "flags only");
    std::cout << description.name;
    for (const auto& [name, value] : EffectiveOptions()) {
      std::cout << " --" << name << "=" << value;
    }
    std::cout << std::endl;
    return run();
  } catch (const OptionError& error) {
    return ReportBadInput(description, "--" + std::string(error.what()));
  } catch (const InputError& error) {
    return ReportBadInput(description, error.what());
  } catch (const std::exception& error) {  // of a library, or memory: nothing is known of it here
    return ReportBadInput(description, std::string("ended by an error: ") + error.what());
  }
}

}  // namespace prism
