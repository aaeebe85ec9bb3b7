function(ament_package)
  install(FILES package.xml DESTINATION share/${PROJECT_NAME})
endfunction()
