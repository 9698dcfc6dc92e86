# Completion for bash, zsh and fish, from what the command says of itself.
if(NOT CMAKE_CROSSCOMPILING)
  set(DVDX_COMPLETIONS ${CMAKE_CURRENT_BINARY_DIR}/completions)
  set(DVDX_COMPLETION_FILES ${DVDX_COMPLETIONS}/dvdx ${DVDX_COMPLETIONS}/_dvdx ${DVDX_COMPLETIONS}/dvdx.fish)
  add_custom_command(OUTPUT ${DVDX_COMPLETION_FILES}
                     COMMAND ${CMAKE_COMMAND} -DCOMMAND=$<TARGET_FILE:dvdx_command> -DFOLDER=${DVDX_COMPLETIONS} -P
                             ${CMAKE_CURRENT_LIST_DIR}/write_completions.cmake
                     DEPENDS dvdx_command ${CMAKE_CURRENT_LIST_DIR}/write_completions.cmake
                     COMMENT "Writing completion for shells" VERBATIM)
  add_custom_target(completions ALL DEPENDS ${DVDX_COMPLETION_FILES})
  if(DEFINED CMAKE_INSTALL_DATADIR)
    install(FILES ${DVDX_COMPLETIONS}/dvdx DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT tools OPTIONAL)
    install(FILES ${DVDX_COMPLETIONS}/_dvdx DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions COMPONENT tools OPTIONAL)
    install(FILES ${DVDX_COMPLETIONS}/dvdx.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT tools OPTIONAL)
  endif()
endif()
