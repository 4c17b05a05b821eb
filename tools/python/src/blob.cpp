#include "hal/weights/blob_file.hpp"
#include "hal/weights/key_ring.hpp"
#include "hal/weights/signature.hpp"
#include "module.hpp"
#include "tools/cli/blob/blob_facts.hpp"

namespace airside::python {

namespace {

/// JSON of the facts, and the weights as numbers.
nb::dict read_blob(const std::string& path, bool damaged) {
  const tools::BlobFacts facts = tools::read_blob_facts(path);
  if (facts.refusal && !damaged) throw *facts.refusal;
  const std::size_t count = facts.weights.size();
  auto* copy = new float[count + 1];
  std::copy(facts.weights.begin(), facts.weights.end(), copy);
  const nb::capsule owner(copy, [](void* p) noexcept { delete[] static_cast<float*>(p); });
  nb::dict out;
  out["json"] = tools::json_of(facts).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  out["weights"] = nb::ndarray<nb::numpy, float, nb::ndim<1>>(copy, {count}, owner);
  nb::list spans;
  for (const tools::BlobLayer& layer : facts.layers)
    spans.append(nb::make_tuple(layer.name, layer.outputs, layer.inputs, layer.begin, layer.bias, layer.end));
  out["spans"] = spans;
  return out;
}

/// Who signed: key id, name, and the counter that the signature covers.
nb::tuple verify_blob(const std::string& path, const std::string& keys) {
  const std::vector<std::byte> bytes = hal::read_blob_file(path);
  hal::KeyRing ring;
  if (std::filesystem::is_directory(keys)) {
    ring = hal::KeyRing::load(keys);
  } else {
    ring.add(hal::read_public_key(keys));
  }
  const auto key = hal::verify_blob(bytes, ring);
  if (!key) hal::throw_blob_error(key.error(), path);
  const BlobHeader header = hal::sound_header(bytes, path);
  return nb::make_tuple(hal::hex_of((*key)->id), std::string((*key)->name.view()), header.security_counter);
}

}  // namespace

void add_blob(nb::module_& m) {
  m.def("read_blob", &read_blob, nb::arg("path"), nb::arg("damaged"),
        "Facts of a blob as JSON text (`airside blob inspect --json`), with its weights.");
  m.def("verify_blob", &verify_blob, nb::arg("path"), nb::arg("keys"),
        "Key id, key name and counter of a signature that holds under a public key file or a folder of them.");
}

}  // namespace airside::python
