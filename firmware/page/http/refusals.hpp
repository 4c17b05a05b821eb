#pragma once
// Whatever airside-page refuses, each with a code that never changes. The page shows the text `refused.CODE` of the
// reader's language (web/texts; a test holds both together), programs go by the code, people without a page read
// English.

#include <string>

#include "airside/fault.hpp"

namespace airside::page {

/// A refusal as such.
struct Refused {
  const char* code;  ///< frozen
  const char* text;  ///< English; may change
};

/// What is answered to an order: done (`code` is empty), or refused.
struct Said {
  int status = 500;       ///< HTTP
  std::string text = {};  ///< English; repeats no text of the request
  const char* code = "";
  const char* field = "";                 ///< of the blob
  std::string found = {}, expected = {};  ///< words or numbers, where they say more than the code
};

/// A refusal with its own text.
inline Said refusal(int status, const Refused& why) { return {.status = status, .text = why.text, .code = why.code}; }

namespace refusals {

// Of a request's head.
inline constexpr Refused too_many_headers{"too_many_headers", "too many header lines"};
inline constexpr Refused host_missing{"host_missing", "Host does not stand there once"};
inline constexpr Refused host_unknown{"host_unknown",
                                      "Host is no name of this box; [page] names in the site file lists them"};
inline constexpr Refused no_page{"no_page", "there is no such page"};
inline constexpr Refused wrong_method{"wrong_method", "not by this method"};
inline constexpr Refused sign_in_viewer{"sign_in_viewer", "sign in as viewer first"};
inline constexpr Refused sign_in_operator{"sign_in_operator", "sign in as operator first"};
inline constexpr Refused sign_in_installer{"sign_in_installer", "sign in as installer first"};
inline constexpr Refused nobody_may{"nobody_may", "nobody may"};
inline constexpr Refused origin_twice{"origin_twice", "Origin stands there twice"};
inline constexpr Refused origin_other{"origin_other", "Origin is another page; nothing is taken from there"};
inline constexpr Refused token_missing{"token_missing",
                                       "no X-Airside-Token of this run or session; GET /token tells it"};
inline constexpr Refused length_missing{"length_missing", "no Content-Length; a body of unknown length is not read"};
inline constexpr Refused length_wrong{"length_wrong", "Content-Length is not one number"};
inline constexpr Refused body_unexpected{"body_unexpected", "a body where none belongs"};
inline constexpr Refused body_too_large{"body_too_large", "longer than anything that is asked for here"};
inline constexpr Refused weights_too_large{"weights_too_large", "longer than any weight blob of this room"};
inline constexpr Refused weights_empty{"weights_empty", "an empty body; expected a signed weight blob"};

// Of signing in.
inline constexpr Refused sign_in_form{"sign_in_form", "expected a role, a line's end, a password"};
inline constexpr Refused passwords_unreadable{"passwords_unreadable",
                                              "the passwords cannot be read; the log of airside-page says why"};
inline constexpr Refused passwords_locked{"passwords_locked", "too many wrong passwords; wait"};
inline constexpr Refused sign_in_busy{"sign_in_busy", "somebody else is signing in at this moment"};
inline constexpr Refused sign_in_no_memory{"sign_in_no_memory", "the box has no memory free to verify a password"};
inline constexpr Refused passwords_changed{"passwords_changed", "the passwords were changed at this moment; try again"};
inline constexpr Refused password_wrong{"password_wrong", "wrong password, or a role without one"};

// Of weights that are sent.
inline constexpr Refused weights_pause{"weights_pause", "the last blob from there was refused just now"};
inline constexpr Refused upload_busy{"upload_busy", "another upload is under way"};
inline constexpr Refused keys_unreadable{"keys_unreadable", "the box cannot read its keys; its log says why"};
inline constexpr Refused weights_waiting{"weights_waiting",
                                         "other weights wait for the daemon already; it looks every 6 min"};
inline constexpr Refused weights_key{"weights_key", text_of(Fault::blob_signature)};
inline constexpr Refused weights_signature{"weights_signature", text_of(Fault::blob_signature)};
inline constexpr Refused weights_truncated{"weights_truncated", text_of(Fault::blob_truncated)};
inline constexpr Refused weights_no_blob{"weights_no_blob", text_of(Fault::blob_magic)};
inline constexpr Refused weights_version{"weights_version", text_of(Fault::blob_version)};
inline constexpr Refused weights_architecture{"weights_architecture", text_of(Fault::blob_architecture)};
inline constexpr Refused weights_topology{"weights_topology", text_of(Fault::blob_topology)};
inline constexpr Refused weights_units{"weights_units", text_of(Fault::blob_units)};
inline constexpr Refused weights_damaged{"weights_damaged", text_of(Fault::blob_digest)};
inline constexpr Refused weights_value{"weights_value", text_of(Fault::blob_value)};
inline constexpr Refused weights_scope{"weights_scope", text_of(Fault::blob_scope)};
inline constexpr Refused weights_size{"weights_size", text_of(Fault::blob_size)};
inline constexpr Refused weights_cycle{"weights_cycle", text_of(Fault::blob_cycle)};

// Of wishes and their folder.
inline constexpr Refused hours_wrong{"hours_wrong",
                                     "hours that are no whole number from 1 to 168; leave the body empty for no end"};
inline constexpr Refused inbox_full{"inbox_full", "the inbox cannot be written"};
inline constexpr Refused inbox_unwritable{"inbox_unwritable", "the inbox cannot be written"};
inline constexpr Refused alarm_form{"alarm_form", "expected the number of an alarm, all, or all and the last number"};
inline constexpr Refused alarm_unknown{"alarm_unknown", "no alarm of that number waits to be seen"};

// Of the point checkout.
inline constexpr Refused sign_off_form{"sign_off_form",
                                       "expected three lines: point, name of the person, time of the reading"};
inline constexpr Refused name_form{"name_form", "expected a name of 1 to 80 bytes"};
inline constexpr Refused point_unknown{"point_unknown", "the point map has no such point"};
inline constexpr Refused reading_old{"reading_old", "the points were read again since; look at the new reading"};
inline constexpr Refused reading_poor{"reading_poor", "what was read is not to be signed"};
inline constexpr Refused sign_off_not_kept{"sign_off_not_kept",
                                           "the sign-off cannot be kept: the page's folder cannot be written"};
inline constexpr Refused not_signed{"not_signed", "no point of that name is signed off"};
inline constexpr Refused sign_off_stays{"sign_off_stays", "the page's folder cannot be written; the sign-off stays"};

// Of what can be read.
inline constexpr Refused no_status{"no_status", "no status yet; is airsided running?"};
inline constexpr Refused no_weights{"no_weights", "no weights yet; airsided gives them out once a day"};
inline constexpr Refused span_unknown{"span_unknown", "span is day, week or month"};

}  // namespace refusals
}  // namespace airside::page
