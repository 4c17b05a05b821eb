#include "firmware/page/http/response.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace airside::page {

std::string without_markup(std::string_view json) {
  std::string safe;
  for (const char c : json) {
    switch (c) {
      case '<': safe += "\\u003c"; break;
      case '>': safe += "\\u003e"; break;
      case '&': safe += "\\u0026"; break;
      default: safe += c;
    }
  }
  return safe;
}

MHD_Response* response_of(const std::string& text) {
  // The library takes a void* that it does not write to when it copies.
  return MHD_create_response_from_buffer(text.size(), const_cast<char*>(text.data()), MHD_RESPMEM_MUST_COPY);
}

MHD_Response* json_of(const Said& said) {
  nlohmann::ordered_json out{{"status", said.status}};
  const auto add = [&out](const char* key, std::string_view text) {
    if (!text.empty()) out[key] = text;
  };
  add("code", said.code);
  add("reason", said.text);
  add("field", said.field);
  add("found", said.found);
  add("expected", said.expected);
  // A site file's words may be in any encoding.
  return response_of(without_markup(out.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)) + "\n");
}

void add_common_lines(MHD_Response* response) {
  const auto add_unless_there = [response](const char* name, const char* value) {
    if (MHD_get_response_header(response, name) == nullptr) MHD_add_response_header(response, name, value);
  };
  add_unless_there("Content-Type", "application/json; charset=utf-8");
  add_unless_there("Cache-Control", "no-store");
  add_unless_there("Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; sandbox");
  static constexpr const char* always[][2] = {
      {"Connection", "close"},
      {"X-Content-Type-Options", "nosniff"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"Cross-Origin-Opener-Policy", "same-origin"},
      {"X-Frame-Options", "DENY"},
      {"Referrer-Policy", "no-referrer"},
  };
  for (const auto& [name, value] : always) MHD_add_response_header(response, name, value);
}

namespace {

/// Whether a line Accept-Encoding takes gzip: named, and not with a weight of 0.
bool takes_gzip(const char* accept_encoding) {
  std::string_view rest = accept_encoding == nullptr ? std::string_view() : std::string_view(accept_encoding);
  while (!rest.empty()) {
    std::string_view word = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), word.size() + 1));
    while (word.starts_with(' ') || word.starts_with('\t')) word.remove_prefix(1);
    if (!word.starts_with("gzip")) continue;
    word.remove_prefix(4);
    if (word.find_first_not_of(' ') == std::string_view::npos) return true;
    const std::size_t weight = word.find("q=");
    if (word.front() != ';' && word.front() != ' ') continue;  // another name that begins alike
    return weight == std::string_view::npos || word.find_first_of("123456789", weight) != std::string_view::npos;
  }
  return false;
}

}  // namespace

MHD_Response* asset_of(const StaticFile& file, const char* if_none_match, const char* accept_encoding, int& status) {
  const bool packs = takes_gzip(accept_encoding);
  const char* etag = packs ? file.packed_etag : file.etag;
  const auto bytes = packs ? file.packed : file.bytes;
  const bool is_known =
      if_none_match != nullptr && std::string_view(if_none_match).find(etag) != std::string_view::npos;
  status = is_known ? MHD_HTTP_NOT_MODIFIED : MHD_HTTP_OK;
  // The library takes a void* that it does not write to.
  MHD_Response* response = MHD_create_response_from_buffer(
      is_known ? 0 : bytes.size(), const_cast<unsigned char*>(bytes.data()), MHD_RESPMEM_PERSISTENT);
  if (response == nullptr) return nullptr;
  MHD_add_response_header(response, "Content-Type", file.type);
  MHD_add_response_header(response, "ETag", etag);
  MHD_add_response_header(response, "Vary", "Accept-Encoding");
  if (packs) MHD_add_response_header(response, "Content-Encoding", "gzip");
  MHD_add_response_header(response, "Cache-Control", "no-cache");
  MHD_add_response_header(response, "Content-Security-Policy",
                          "default-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'; "
                          "object-src 'none'");
  return response;
}

}  // namespace airside::page
