#include "firmware/page/http/response.hpp"

#include <fmt/format.h>

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

MHD_Response* json_of(int status, std::string_view reason) {
  return response_of(without_markup(fmt::format("{{\"status\":{},\"reason\":\"{}\"}}\n", status, reason)));
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

MHD_Response* asset_of(const StaticFile& file, const char* if_none_match, int& status) {
  const bool is_known =
      if_none_match != nullptr && std::string_view(if_none_match).find(file.etag) != std::string_view::npos;
  status = is_known ? MHD_HTTP_NOT_MODIFIED : MHD_HTTP_OK;
  // The library takes a void* that it does not write to.
  MHD_Response* response = MHD_create_response_from_buffer(
      is_known ? 0 : file.bytes.size(), const_cast<unsigned char*>(file.bytes.data()), MHD_RESPMEM_PERSISTENT);
  if (response == nullptr) return nullptr;
  MHD_add_response_header(response, "Content-Type", file.type);
  MHD_add_response_header(response, "ETag", file.etag);
  MHD_add_response_header(response, "Cache-Control", "no-cache");
  MHD_add_response_header(response, "Content-Security-Policy",
                          "default-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'; "
                          "object-src 'none'");
  return response;
}

}  // namespace airside::page
