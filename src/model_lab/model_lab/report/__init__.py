"""What is said of a diagnosis and of a learned curve: in sentences, and by HTML pages that need
nothing else. The module for pages, `report.page`, is loaded only when a page is written, as that
takes longer than most answers.
"""
