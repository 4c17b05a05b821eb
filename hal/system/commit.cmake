# Writes the source that names the commit of this build, where it would change.
# Called at each build: cmake -DSOURCE=... -DOUTPUT=... [-DCOMMIT=...] -P commit.cmake
if(NOT COMMIT)
  set(COMMIT unknown)
  # Only this tree's own repository counts, not one that it happens to lie in.
  execute_process(COMMAND git -C ${SOURCE} rev-parse --show-toplevel OUTPUT_VARIABLE top RESULT_VARIABLE failed
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NOT failed)
    file(REAL_PATH "${top}" top)
    file(REAL_PATH "${SOURCE}" here)
    if(top STREQUAL here)
      execute_process(COMMAND git --no-optional-locks -C ${SOURCE} describe --always --dirty --abbrev=12
                      OUTPUT_VARIABLE described RESULT_VARIABLE failed OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
      if(NOT failed AND described MATCHES "^[-._/+A-Za-z0-9]+$")
        set(COMMIT ${described})
      endif()
    endif()
  endif()
endif()
set(text "namespace airside::hal {
const char* commit();
const char* commit() { return \"${COMMIT}\"; }
}  // namespace airside::hal
")
set(before "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} before)
endif()
if(NOT before STREQUAL text)
  file(WRITE ${OUTPUT} "${text}")
endif()
