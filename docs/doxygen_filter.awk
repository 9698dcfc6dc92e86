# Our headers' comments as Doxygen reads them: "//" before a declaration becomes "///", behind one "///<" (and so do the lines that
# go on below it), and the first lines of a file are about the file.
# Text that Doxygen would take for tags is escaped.
function column(text) { return match(text, /\/\//) }
function marked(text, mark,   at) {
  at = column(text)
  body = substr(text, at + 2)
  gsub(/[<>@]/, "\\\\&", body)
  return substr(text, 1, at - 1) mark body
}
/^ *\/\// {
  if (behind && column($0) == behind) { print marked($0, "///<"); next }
  behind = 0
  if (NR == 1) printf "/// @file\n"
  print marked($0, "///")
  next
}
/[;,{}()a-zA-Z0-9_] +\/\/ / && !/"[^"]*\/\/[^"]*"/ {
  behind = column($0)
  if ($0 !~ /^#/ && $0 !~ /\/\/ NOLINT/ && $0 !~ /^} /) print marked($0, "///<")
  else print
  next
}
{ behind = 0; print }
