# cmake -DCOMMAND=<dvdx> -DPAGE=<dvdx.1> -P write_page.cmake
#
# The manual page, from what the command and each of its subcommands say to --help.

# take_help(NAME ARGUMENT...): NAME_example and NAME_text, both in roff
function(take_help name)
  execute_process(COMMAND ${COMMAND} ${ARGN} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
  if(NOT help MATCHES "^Example:\n  ([^\n]+)\n\n(.+)$")
    message(FATAL_ERROR "dvdx ${ARGN} --help begins with no example")
  endif()
  set(example "${CMAKE_MATCH_1}")
  set(text "\n${CMAKE_MATCH_2}")
  string(REGEX REPLACE "\n+$" "\n" text "${text}")
  string(REGEX REPLACE "\n   +" "  " text "${text}") # what an option says, where its name takes a line of its own
  string(REGEX REPLACE "\n  ([^\n]*[^ \n])  +([^\n]+)" "\n.TP\n.B \\1\n\\2" text "${text}")
  string(REGEX REPLACE "\n+(Positionals|Options|Subcommands):" "\n.PP\n\\1:" text "${text}")
  string(REGEX REPLACE "\nUsage: ([^\n]+)" "\n.PP\n.B \\1" text "${text}")
  foreach(part example text)
    string(REPLACE "\\" "\\e" ${part} "${${part}}")
    string(REPLACE "-" "\\-" ${part} "${${part}}")
    set(${name}_${part} "${${part}}" PARENT_SCOPE)
  endforeach()
endfunction()

take_help(dvdx)
execute_process(COMMAND ${COMMAND} --version OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "^\n([^\n]+)\\.\n" first_line "${dvdx_text}")
string(CONCAT page ".TH DVDX 1 \"\" \"dvdx ${version}\" \"User Commands\"\n.SH NAME\ndvdx \\- ${CMAKE_MATCH_1}\n"
       ".SH DESCRIPTION${dvdx_text}.SH EXAMPLES\n.nf\n${dvdx_example}\n")

string(REGEX REPLACE "^.*\nSubcommands:" "" names "${dvdx_text}")
string(REGEX MATCHALL "\n\\.B [a-z]+" names "${names}")
set(sections ".SH SUBCOMMANDS\n")
foreach(name IN LISTS names)
  string(REGEX REPLACE "^\n\\.B " "" name "${name}")
  take_help(help ${name})
  string(APPEND page "${help_example}\n")
  string(APPEND sections ".SS dvdx ${name}${help_text}")
endforeach()
file(WRITE ${PAGE} "${page}.fi\n${sections}")
