// airside completion: hidden; `cmake --install` puts what it prints where bash and zsh look for it.

#include "tools/cli/completion.hpp"

#include <fmt/format.h>

#include <fstream>
#include <memory>
#include <vector>

#include "hal/text/input_error.hpp"
#include "tools/cli/command.hpp"

namespace airside::tools {
namespace {

/// One word that can be typed, and its description's first line.
struct Word {
  std::string text, what;
};

/// A command as it is typed, such as "airside gap fit", and what can come after it.
struct Level {
  std::string path;
  std::vector<Word> commands, options;
};

/// Values of one option, such as those after "airside simulate --plant".
struct Choice {
  std::string place;
  std::vector<std::string> values;
};

struct Tree {
  std::vector<Level> levels;
  std::vector<Choice> choices;
};

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// "TEXT:{rc,energyplus}" holds two values; other type names hold none.
std::vector<std::string> values_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t open = type.find('{'), close = type.find('}', open);
  if (open == std::string::npos || close == std::string::npos) return {};
  return CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
}

void collect(const CLI::App& app, const std::string& path, Tree& tree) {
  Level level{path, {}, {}};
  for (const CLI::Option* option : app.get_options({})) {
    if (option->get_group().empty()) continue;
    std::vector<Word> names;
    for (const std::string& name : option->get_snames()) names.push_back({"-" + name, {}});
    for (const std::string& name : option->get_lnames()) names.push_back({"--" + name, {}});
    const std::vector<std::string> values = values_of(*option);
    for (Word& name : names) {
      name.what = first_line(option->get_description());
      level.options.push_back(name);
      if (!values.empty()) tree.choices.push_back({path + " " + name.text, values});
    }
  }
  std::vector<const CLI::App*> below;
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->get_name().empty() || command->get_group().empty()) continue;
    level.commands.push_back({command->get_name(), first_line(command->get_description())});
    below.push_back(command);
  }
  tree.levels.push_back(level);
  for (const CLI::App* command : below) collect(*command, path + " " + command->get_name(), tree);
}

Tree tree_of(const CLI::App& app) {
  Tree tree;
  collect(app, app.get_name(), tree);
  return tree;
}

std::string joined(const std::vector<Word>& words) {
  std::string text;
  for (const Word& word : words) text += (text.empty() ? "" : " ") + word.text;
  return text;
}

/// Text between single quotes of a shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// The patterns of a `case` that goes one command deeper.
std::string deeper(const Tree& tree) {
  std::string patterns;
  for (const Level& level : tree.levels) {
    if (level.path.find(' ') != std::string::npos) patterns += (patterns.empty() ? "" : "|") + quoted(level.path);
  }
  return patterns;
}

/// A word of zsh's _describe: "name:what", colons of the name escaped.
std::string described(const std::vector<Word>& words) {
  std::string text;
  for (const Word& word : words) {
    std::string name;
    for (const char c : word.text) name += c == ':' ? std::string("\\:") : std::string(1, c);
    text += " " + quoted(name + ":" + word.what);
  }
  return text;
}

struct CompletionCommand {
  std::string shell, out;

  void run(const CLI::App& app) const {
    const std::string text = shell == "bash" ? bash_completion(app) : zsh_completion(app);
    if (out.empty()) {
      fmt::print("{}", text);
      return;
    }
    std::ofstream file(out);
    file << text;
    if (!file.flush()) {
      throw hal::InputError("-o " + out, "a file that cannot be written", "a writable path", "choose another");
    }
  }
};

}  // namespace

std::string bash_completion(const CLI::App& app) {
  const Tree tree = tree_of(app);
  const std::string& name = app.get_name();
  std::string text = fmt::format(R"(# bash completion of {0}; printed by `{0} completion bash`.
_{0}() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD - 1]}} path={0} i commands='' options=''
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "$path ${{COMP_WORDS[i]}}" in
      {1}) path="$path ${{COMP_WORDS[i]}}" ;;
    esac
  done
  COMPREPLY=()
  case "$path $prev" in
)",
                                 name, deeper(tree));
  for (const Choice& choice : tree.choices) {
    text += fmt::format("    {}) mapfile -t COMPREPLY < <(compgen -W {} -- \"$cur\"); return ;;\n",
                        quoted(choice.place), quoted(fmt::format("{}", fmt::join(choice.values, " "))));
  }
  text += "  esac\n  case $path in\n";
  for (const Level& level : tree.levels) {
    text += fmt::format("    {}) commands={} options={} ;;\n", quoted(level.path), quoted(joined(level.commands)),
                        quoted(joined(level.options)));
  }
  return text + fmt::format(R"(  esac
  if [[ $cur == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$cur")
  elif [[ $prev != -* || -z $cur ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$cur")
  fi
}}
complete -o default -F _{0} {0}
)",
                            name);
}

std::string zsh_completion(const CLI::App& app) {
  const Tree tree = tree_of(app);
  const std::string& name = app.get_name();
  std::string text = fmt::format(R"(#compdef {0}
# zsh completion of {0}; printed by `{0} completion zsh`.
_{0}() {{
  local where={0} i
  local -a commands options
  for ((i = 2; i < CURRENT; ++i)); do
    case "$where $words[i]" in
      ({1}) where="$where $words[i]" ;;
    esac
  done
  case "$where $words[CURRENT-1]" in
)",
                                 name, deeper(tree));
  for (const Choice& choice : tree.choices) {
    text += fmt::format("    ({})  compadd --", quoted(choice.place));
    for (const std::string& value : choice.values) text += " " + quoted(value);
    text += "; return ;;\n";
  }
  text += "  esac\n  case $where in\n";
  for (const Level& level : tree.levels) {
    text += fmt::format("    ({})\n      commands=({} )\n      options=({} ) ;;\n", quoted(level.path),
                        described(level.commands), described(level.options));
  }
  return text + fmt::format(R"(  esac
  if [[ $words[CURRENT] == -* ]]; then
    _describe -o option options
  elif (( $#commands )) && [[ $words[CURRENT-1] != -* ]]; then
    _describe command commands
  else
    _files
  fi
}}
_{0} "$@"
)",
                            name);
}

void add_completion(CLI::App& app) {
  auto state = std::make_shared<CompletionCommand>();
  CLI::App* command = app.add_subcommand("completion", "print completion of this command line for a shell");
  command->group("");
  command->add_option("shell", state->shell, "bash or zsh")->required()->check(CLI::IsMember({"bash", "zsh"}));
  command->add_option("-o,--out", state->out, "file to write instead of standard output");
  command->callback([state, &app] { state->run(app); });
}

}  // namespace airside::tools
