// airside keygen, sign, push, rollback, hand-back, release: how weights, and an operator's word, get to a box.

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <regex>

#include "airside/controller/instances.hpp"
#include "airside/topologies.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/storage/atomic_file.hpp"
#include "hal/storage/storage_file.hpp"
#include "hal/text/input_error.hpp"
#include "hal/weights/blob_file.hpp"
#include "hal/weights/mailbox.hpp"
#include "hal/weights/signature.hpp"
#include "tools/cli/command.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

/// Writes a file that must not exist yet, with just these permissions from its first byte on.
void write_new(const fs::path& path, const std::string& text, mode_t mode) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (fd < 0) {
    throw hal::InputError(path.string(), std::strerror(errno), "a new file", "choose another name with -o");
  }
  const hal::StorageFile file(fd);
  const auto bytes = std::as_bytes(std::span(text));
  hal::StoreResult<void> done = file.write_at(bytes, 0, "write key");
  if (done) done = file.sync(hal::Sync::full, "sync key");
  if (!done) {
    ::unlink(path.c_str());
    throw hal::InputError(path.string(), hal::describe(done.error()), "a disk with room for a key", "make room");
  }
}

struct KeygenCommand {
  std::string out = "airside", name;
  bool json = false;

  void run() const {
    const fs::path secret = out + ".key", open = out + ".pub";
    for (const fs::path& path : {secret, open}) {
      if (!fs::exists(path)) continue;
      throw hal::InputError(path.string(), "a file that is already there", "a new name", "choose another with -o");
    }
    const hal::SecretKey key = hal::make_key(name.empty() ? fs::path(out).filename().string() : name);
    write_new(secret, hal::secret_key_text(key), 0600);
    write_new(open, hal::public_key_text(key.open), 0644);
    const std::string id = hal::hex_of(key.open.id);
    if (json) {
      fmt::print("{}\n", nlohmann::json{{"secret", secret.string()}, {"public", open.string()}, {"key_id", id}}.dump());
      return;
    }
    fmt::print("wrote {} (keep it on this host) and {} (id {})\n", secret.string(), open.string(), id);
    fmt::print("Copy {} to /etc/airside/keys/ of every box that shall take your weights.\n", open.filename().string());
  }
};

struct SignCommand {
  std::string blob, key, out;
  std::optional<std::string> scope;
  std::optional<std::int64_t> counter;
  bool json = false;

  /// For which site the blob is; weights from a box or a twin are for any.
  void set_scope(std::span<std::byte> bytes) const {
    BlobHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    if (scope->size() > header.site_scope.size()) {
      throw hal::InputError("--scope", fmt::format("{} bytes", scope->size()),
                            fmt::format("at most {}", header.site_scope.size()), "shorten [site] scope of the box");
    }
    header.site_scope = {};
    scope->copy(header.site_scope.data(), header.site_scope.size());
    std::memcpy(bytes.data(), &header, sizeof header);
  }

  void run() const {
    std::vector<std::byte> bytes = hal::read_blob_file(blob);
    const hal::SecretKey secret = hal::read_secret_key(key);
    // Seconds since 1970 rise by themselves on every host that signs; a box takes only what is newer.
    const auto count = static_cast<std::uint64_t>(counter.value_or(std::int64_t{std::time(nullptr)}));
    hal::sound_header(bytes, blob);  // a signature would make damage genuine
    if (scope) set_scope(bytes);
    hal::sign_blob(bytes, secret, count);
    const std::string path = out.empty() ? blob : out;
    hal::write_blob_file(path, bytes);
    const std::string id = hal::hex_of(secret.open.id);
    if (json) {
      fmt::print("{}\n", nlohmann::json{{"blob", path}, {"key_id", id}, {"security_counter", count}}.dump());
      return;
    }
    fmt::print("signed {} with key {} ({}), counter {}\n", path, id, secret.open.name.view(), count);
  }
};

/// The inbox that a person means: a folder, the site file of a box on this machine, or the folder that has it.
std::string inbox_of(const std::string& target) {
  std::error_code none;
  const bool has_site = fs::is_regular_file(fs::path(target) / "site.toml", none);
  const std::string file = has_site ? (fs::path(target) / "site.toml").string() : target;
  if (fs::path(file).extension() != ".toml") {
    if (!fs::exists(fs::path(target) / "status.json", none)) return target;
    throw hal::InputError(file, "a state folder, which has a status.json", "the inbox of a box",
                          "give the folder of [inbox] dir in its site file, or that site file");
  }
  const std::string inbox = hal::read_site_file(file, hal::site_rules()).inbox_dir;
  if (!inbox.empty()) return inbox;
  throw hal::InputError(file + ": [inbox] dir", "an empty text", "a folder that the daemon looks into",
                        "name one in the site file");
}

void drop(const std::string& target, const std::string& name, std::span<const std::byte> bytes) {
  const std::string inbox = inbox_of(target);
  std::error_code error;
  if (!fs::is_directory(inbox, error)) {
    throw hal::InputError(inbox, error ? error.message() : "no folder", "the inbox of a box, or a copy of it to carry",
                          "give the folder of [inbox] dir in its site file, that site file, or http://HOST:PORT");
  }
  // Run by root beside other users, this must not write where a link of theirs leads.
  const auto folder = hal::StorageFile::open_existing_dir(inbox.c_str(), hal::FolderLink::trusted);
  const hal::StoreResult<void> written =
      folder ? hal::write_file_atomically(*folder, name, bytes) : tl::make_unexpected(folder.error());
  if (!written) {
    throw hal::InputError(inbox, hal::describe(written.error()), "a folder that this user may write",
                          "run it as the user airside, or ask the box's administrator");
  }
}

/// The page of a host that is given without more, such as `ahu-3` or `10.0.0.7:8350`; empty for anything else, a folder
/// of that name included.
std::string page_of(const std::string& target) {
  static const std::regex bare(R"(([A-Za-z0-9][A-Za-z0-9.-]*)(:\d{1,5})?)");
  std::smatch parts;
  std::error_code none;
  const bool is_host = std::regex_match(target, parts, bare) && !target.ends_with(".toml");
  if (!is_host || fs::exists(target, none)) return {};
  const std::string host = parts[1];
  const bool here = host == "localhost" || host.starts_with("127.");  // where the page needs no certificate
  return (here ? "http://" : "https://") + host + (parts[2].matched ? parts[2].str() : ":8350");
}

constexpr const char* default_site = "/etc/airside/site.toml";

/// The site of the box that looks into `inbox`: the file given, else the one beside the inbox or the box's own, where
/// it names that inbox. Nothing where none does.
std::optional<hal::SiteFile> site_of(const std::string& inbox, const std::string& given) {
  if (!given.empty()) return hal::read_site_file(given, hal::site_rules());
  for (const std::string& path : {(fs::path(inbox) / ".." / "site.toml").string(), std::string(default_site)}) {
    std::error_code none;
    if (!fs::exists(path, none)) continue;
    try {
      hal::SiteFile site = hal::read_site_file(path, hal::site_rules());
      if (fs::equivalent(site.inbox_dir, inbox, none)) return site;
    } catch (const hal::InputError& unread) {  // the daemon's affair: it need not be the site of this inbox
      fmt::print(stderr, "airside: {}\n", unread.what());
    }
  }
  return {};
}

/// What the box would refuse as soon as it looks: a key that it does not know, another topology, units or site.
/// Errors: hal::InputError.
void refuse_for_site(const std::string& blob, std::span<const std::byte> bytes, const hal::SiteFile& site) {
  hal::KeyRing keys;
  const char* unread = keys.reload(site.keys_dir.c_str(), [](const char*, const char*) {});  // as the daemon does
  if (unread != nullptr) {
    fmt::print(stderr, "airside: {}: {}; whether the box knows the key of {} is not checked\n", site.keys_dir, unread,
               blob);
  } else if (const auto key = hal::verify_blob(bytes, keys); !key) {
    throw hal::InputError(blob + ": " + key.error().field, hal::complaint_of(key.error().fault).found,
                          "a signature of a key in " + (site.keys_dir.empty() ? "[weights] keys" : site.keys_dir),
                          "sign it with a key that the box knows, or copy the public key there");
  }
  with_topology(site.topology.c_str(), [&]<class T>(T) {
    auto payload = std::make_unique<typename WeightBlob<T>::Payload>();
    payload->site = parse_shape(site.topology.c_str());
    payload->cycle = cycle_of_minutes(site.cycle_min);
    hal::decode_blob<T>(bytes, site.scope, blob, *payload);
  });
}

struct PushCommand {
  std::string blob, target, site;
  BoxAccess access;
  SendBlob over_http = nullptr;
  bool json = false;

  void check_for_box(std::span<const std::byte> bytes) const {
    const bool is_site = fs::path(target).extension() == ".toml";
    const std::optional<hal::SiteFile> box = site_of(inbox_of(target), site.empty() && is_site ? target : site);
    if (box) return refuse_for_site(blob, bytes, *box);
    fmt::print(stderr,
               "airside: {}: no site file is known that names this inbox, so topology, site and key of {} are not "
               "checked; --site FILE names it\n",
               target, blob);
  }

  /// As airside-page has it: two people's weights do not replace one another unseen.
  void refuse_beside_another(const BlobHeader& header) const {
    const std::string path = (fs::path(inbox_of(target)) / hal::Mailbox::blob_name).string();
    if (!hal::Mailbox::waits(path, header)) return;
    throw hal::InputError(path, "other weights that wait for the daemon, of another key or not older",
                          "an inbox without", "wait 6 min until the daemon has looked, or take that file away");
  }

  void run() const {
    const std::vector<std::byte> bytes = hal::read_blob_file(blob);
    const BlobHeader header = hal::sound_header(bytes, blob);
    if (header.key_id == hal::KeyId{}) {
      throw hal::InputError(blob + ": key_id", "an unsigned blob", "a signed one, since boxes take no other",
                            "airside sign " + blob + " --key YOUR.key");
    }
    const bool is_address = target.starts_with("http://") || target.starts_with("https://");
    const std::string address = is_address ? target : page_of(target);
    if (over_http != nullptr && !address.empty()) {
      nlohmann::json sent = over_http(address, bytes, access);
      sent["blob"] = blob;
      if (json) {
        fmt::print("{}\n", sent.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
      } else {
        fmt::print("{} ({} bytes) lies in the inbox behind {}: {}\n", blob, bytes.size(), address,
                   sent["said"].get<std::string>());
      }
      return;
    }
    check_for_box(bytes);
    refuse_beside_another(header);
    drop(target, hal::Mailbox::blob_name, bytes);
    if (json) {
      fmt::print("{}\n", nlohmann::json{{"blob", blob}, {"bytes", bytes.size()}, {"inbox", inbox_of(target)}}.dump());
      return;
    }
    fmt::print(
        "{} ({} bytes) lies in {}; the daemon looks within 6 min, and then tries it for a day, if it is newer than "
        "what it took\n",
        blob, bytes.size(), inbox_of(target));
  }
};

/// A wish of one word, dropped as an empty file.
struct WishCommand {
  std::string target = default_site;
  std::string_view wish;
  const char* sentence;
  int hours = 0;  ///< of a release: after which it ends by itself; 0: it does not
  bool json = false;

  void run() const {
    const std::string text = hours == 0 ? std::string() : std::to_string(hours);
    const std::string inbox = inbox_of(target);
    drop(target, std::string(wish), std::as_bytes(std::span(text)));
    if (inbox == target && !site_of(inbox, "")) {  // given as a folder, not by its site
      fmt::print(stderr,
                 "airside: {}: no site file is known that names this inbox, so a daemon may not look there; see by "
                 "airside status that it follows\n",
                 inbox);
    }
    if (json) {
      fmt::print("{}\n", nlohmann::json{{"wish", wish}, {"inbox", inbox}}.dump());
      return;
    }
    if (hours != 0) {
      fmt::print(
          "the daemon writes nothing more, from now on; it takes the AHU again within a row and a control cycle "
          "after {} h, or after `airside hand-back`\n",
          hours);
      return;
    }
    fmt::print("{}\n", sentence);
  }
};

constexpr const char* json_help = "print one JSON object and nothing else on standard output";
constexpr const char* target_help = "the box's inbox folder, its site file, or the folder of that file";

void add_wish(CLI::App& app, const char* name, std::string_view wish, const char* help, const char* sentence) {
  auto self = std::make_shared<WishCommand>();
  self->wish = wish;
  self->sentence = sentence;
  CLI::App* c = app.add_subcommand(name, help);
  c->add_option("target", self->target, target_help)->capture_default_str();
  if (wish == hal::Mailbox::release_name) {
    c->add_option("--hours", self->hours, "take the AHU again after that many hours (default: not before a hand-back)")
        ->check(CLI::Range(1, hal::Mailbox::longest_release_h));
  }
  c->add_flag("--json", self->json, json_help);
  c->callback([self] { self->run(); });
}

}  // namespace

void add_weights(CLI::App& app, SendBlob over_http) {
  auto keygen = std::make_shared<KeygenCommand>();
  CLI::App* k = app.add_subcommand("keygen", "make a pair of keys: one signs weights, the other lets boxes know them");
  k->add_option("-o,--out", keygen->out, "NAME.key and NAME.pub are written")->capture_default_str();
  k->add_option("--name", keygen->name, "whose key it is, for people (default: NAME)");
  k->add_flag("--json", keygen->json, json_help);
  k->callback([keygen] { keygen->run(); });

  auto sign = std::make_shared<SignCommand>();
  CLI::App* s = app.add_subcommand("sign", "sign a weight blob, so that boxes take it");
  s->add_option("blob", sign->blob, "the blob")->required();
  s->add_option("--key", sign->key, "secret key that `airside keygen` made")->required();
  s->add_option("-o,--out", sign->out, "signed blob (default: the blob itself)");
  s->add_option("--scope", sign->scope,
                "the one site that shall take it, by its [site] scope; \"\" for any (default: as it is)");
  s->add_option("--counter", sign->counter, "must rise from blob to blob (default: seconds since 1970)")
      ->check(CLI::Range(std::int64_t{1}, std::numeric_limits<std::int64_t>::max()));
  s->add_flag("--json", sign->json, json_help);
  s->callback([sign] { sign->run(); });

  auto push = std::make_shared<PushCommand>();
  CLI::App* p = app.add_subcommand("push", "give a signed weight blob to a box");
  p->add_option("blob", push->blob, "a signed blob")->required();
  p->add_option("target", push->target,
                over_http != nullptr ? "the box's inbox folder, its site file, HOST (its airside-page at "
                                       "https://HOST:8350) or http(s)://HOST:PORT"
                                     : target_help)
      ->required();
  if (over_http != nullptr) {
    p->add_option("--ca", push->access.ca, "PEM file of the certificates to trust, such as the box's own");
    p->add_option("--access", push->access.key_file,
                  "file with a key of the box's page, where passwords are set (airside-page --new-key installer)");
  }
  p->add_option(
      "--site", push->site,
      "site file of the box, to check topology, site and key against (default: the target, if it is one, else\n"
      "the one beside the inbox or /etc/airside/site.toml, where it names this inbox)");
  push->over_http = over_http;
  p->add_flag("--json", push->json, json_help);
  p->callback([push] { push->run(); });

  add_wish(app, "rollback", hal::Mailbox::rollback_name, "let a box return to the weights before the last push",
           "the daemon goes back within 6 min, to the schedule where there were none before; without a push it changes "
           "nothing");
  add_wish(app, "release", hal::Mailbox::release_name,
           "let a box stop writing, so that the AHU's own controller takes over",
           "the daemon writes nothing more, from now on, until `airside hand-back`; its status says so within 6 min");
  add_wish(app, "hand-back", hal::Mailbox::hand_back_name, "give a released or overridden AHU back to the box",
           "the daemon takes over again within a row and a control cycle");
}

}  // namespace airside::tools
