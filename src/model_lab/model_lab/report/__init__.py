"""What is said of a diagnosis and of a learned curve: in sentences, and by HTML pages that need
nothing else. To load the pages (`report.page`) takes longer than most answers; nothing else does.
"""
