// The extension `airside._airside`: the host tool's own functions, bound for Python.

#include "module.hpp"

#include "tools/run/run_facts.hpp"

NB_MODULE(_airside, m) {
  using namespace airside::python;
  nb::set_leak_warnings(false);
  translate_errors();
  m.doc() = "The host tool's own functions. Use the package airside, which gives them types.";
  m.def("program_text", &airside::tools::program_text, "Version and commit of the program, as `airside --version`.");
  add_blob(m);
  add_log(m);
  add_simulate(m);
  add_gap(m);
}
