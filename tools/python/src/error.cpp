#include "hal/text/input_error.hpp"

#include "module.hpp"

namespace airside::python {

void translate_errors() {
  nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
    try {
      std::rethrow_exception(thrown);
    } catch (const hal::InputError& e) {
      const nb::object type = nb::module_::import_("airside._errors").attr("InputError");
      const nb::object error = type.attr("in_pythons_words")(e.place(), e.found(), e.expected(), e.remedy());
      PyErr_SetObject(type.ptr(), error.ptr());
    }
  });
}

std::function<void(double)> progress_of(const nb::object& progress) {
  return [&progress](double share) {
    const nb::gil_scoped_acquire held;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (!progress.is_none()) progress(share);
  };
}

}  // namespace airside::python
