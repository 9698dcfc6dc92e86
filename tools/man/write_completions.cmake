# cmake -DCOMMAND=<dvdx> -DFOLDER=<to write> -P write_completions.cmake
#
# Commands and options as --help has them; all else that is typed is a file, or a value that a --help names in braces.

# take_help(ARGUMENT...): text, without what is wider than names
function(take_help)
  execute_process(COMMAND ${COMMAND} ${ARGN} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
  set(text "${help}" PARENT_SCOPE)
endfunction()

# options_in(TEXT): options, a list
function(options_in text)
  string(REGEX MATCHALL "\n  (-h,)?--[a-z-]+" lines "${text}")
  set(found)
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "^.*(--[a-z-]+)$" "\\1" option "${line}")
    list(APPEND found ${option})
  endforeach()
  set(options "${found}" PARENT_SCOPE)
endfunction()

take_help()
string(REGEX REPLACE "^.*\nSubcommands:" "" names "${text}")
string(REGEX MATCHALL "\n  [a-z]+ +[^\n]+" commands "${names}")
if(NOT commands)
  message(FATAL_ERROR "dvdx --help names no commands")
endif()

set(bash_cases)
set(zsh_commands)
set(zsh_cases)
set(fish_lines)
set(all_names)
foreach(line IN LISTS commands)
  string(REGEX REPLACE "^\n  ([a-z]+) +.*$" "\\1" name "${line}")
  string(REGEX REPLACE "^\n  [a-z]+ +(.*)$" "\\1" does "${line}")
  string(REPLACE "'" "" does "${does}")
  string(REPLACE "`" "" does "${does}")
  string(REPLACE ":" "" does "${does}")
  list(APPEND all_names ${name})
  take_help(${name})
  options_in("${text}")
  string(REPLACE ";" " " spaced "${options}")
  string(APPEND bash_cases "    ${name}) words='${spaced}' ;;\n")
  string(APPEND zsh_commands "  '${name}:${does}'\n")
  string(APPEND zsh_cases "  ${name}) options=(${spaced}) ;;\n")
  string(APPEND fish_lines "complete -c dvdx -n __fish_use_subcommand -f -a ${name} -d '${does}'\n")
  foreach(option IN LISTS options)
    string(REGEX MATCH "\n  (-h,)?${option} [^\n]*{([a-z0-9_,-]+)}" ignored "${text}")
    set(values "${CMAKE_MATCH_2}")
    string(SUBSTRING "${option}" 2 -1 word)
    set(line "complete -c dvdx -n '__fish_seen_subcommand_from ${name}' -l ${word}")
    if(values)
      string(REPLACE "," " " values "${values}")
      string(APPEND line " -x -a '${values}'")
      string(APPEND bash_values "    ${name}${option}) words='${values}' ;;\n")
    endif()
    string(APPEND fish_lines "${line}\n")
  endforeach()
endforeach()
string(REPLACE ";" " " all_names "${all_names}")

file(WRITE ${FOLDER}/dvdx "# bash completion for dvdx
_dvdx() {
  local word=\${COMP_WORDS[COMP_CWORD]} words=
  if [ \"$COMP_CWORD\" -eq 1 ]; then
    COMPREPLY=($(compgen -W '${all_names} --help --version' -- \"$word\"))
    return
  fi
  case \${COMP_WORDS[1]}\${COMP_WORDS[COMP_CWORD - 1]} in
${bash_values}    help*) words='${all_names}' ;;
  esac
  [ -n \"$words\" ] || [[ $word != -* ]] || case \${COMP_WORDS[1]} in
${bash_cases}  esac
  if [ -n \"$words\" ]; then
    COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))
  else
    COMPREPLY=($(compgen -f -- \"$word\"))
  fi
}
complete -o filenames -F _dvdx dvdx
")
file(WRITE ${FOLDER}/_dvdx "#compdef dvdx
local -a commands options
commands=(
${zsh_commands})
if ((CURRENT == 2)); then
  _describe command commands
  return
fi
case $words[2] in
${zsh_cases}esac
if [[ $PREFIX == -* ]]; then
  compadd -- $options
elif [[ $words[2] == help ]]; then
  _describe command commands
else
  _files
fi
")
file(WRITE ${FOLDER}/dvdx.fish "# fish completion for dvdx\n${fish_lines}")
