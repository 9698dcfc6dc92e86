# cmake -DNPM=... -DNODE=... -DTARGET=FOLDER -P build_pages.cmake: the pages into FOLDER. Says so where they cannot be built, and
# is done: everything else works without them.
function(run_or_leave what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(NOT result EQUAL 0)
    message("The pages are not built: ${what} failed:\n${said}")
    set(failed TRUE PARENT_SCOPE)
  endif()
endfunction()

if(NOT EXISTS node_modules/.package-lock.json OR package-lock.json IS_NEWER_THAN node_modules/.package-lock.json)
  run_or_leave("npm ci" ${NPM} ci --no-progress --fetch-retries=1)
endif()
if(NOT failed)
  run_or_leave("building them" ${NODE} build.mjs ${TARGET})
endif()
